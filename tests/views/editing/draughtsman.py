"""Drawing a whole model by hand: what stands in it, put down in its order by clicks and keys."""

from __future__ import annotations

import json
from typing import Any

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject, features_of
from dineros.metamodel.constraints.wording import words_for
from tests.views.editing.driving import Hand

COLUMNS = 6
ROWS = 4


class Draughtsman:
    """Who draws a system model.

    Parameters
    ----------
    hand : Hand
        A page with a new model.
    """

    def __init__(self, hand: Hand) -> None:
        self.hand = hand

    def draw(self, model: sym.SystemModel) -> None:
        """Draw everything."""
        self._fill(model)
        if model.tokenType is not None:
            self._token_type(model.tokenType)
        for number, page in enumerate(model.pages):
            self._put(page, number)
        for page in model.pages:
            self._sheet(page)
        for number, channel in enumerate(model.channels, len(model.pages)):
            self._channel(channel, number)

    def _fill(self, element: EObject, *left_out: str) -> None:
        """Fill in attributes of what the form shows, where they are not as by default."""
        for name, feature in features_of(type(element)).items():
            value = getattr(element, name)
            if feature.is_reference or name in left_out or value == feature.get_default_value():
                continue
            field = self.hand.page.locator(f"#field-{name}")
            kind = field.evaluate("(field) => field.type")
            if kind == "checkbox":
                field.set_checked(bool(value))
            elif kind == "select-one":
                field.select_option(str(value))
            elif field.input_value() != str(value):
                field.fill(str(value))
                field.press("Enter")
            self.hand.idle()

    def _token_type(self, token_type: sym.TokenType) -> None:
        form = self.hand.page.locator("#form")
        group = form.get_by_role("group", name="token type", exact=True)
        group.get_by_role("button", name="+ token type", exact=True).click()
        self.hand.idle()
        self._fill(token_type)
        for field in token_type.fields:
            self.hand.page.get_by_role("button", name="+ token field", exact=True).click()
            self.hand.dialog(name=field.name)
            self._fill(field, "name")
            self.hand.page.locator("#form").get_by_role("button", name=token_type.name, exact=True).click()
        self.hand.page.keyboard.press("Escape")
        self.hand.page.keyboard.press("Escape")

    def _put(self, element: pn.PageObject, number: int) -> None:
        x, y = 0.1 + 0.8 * (number % COLUMNS) / (COLUMNS - 1), 0.12 + 0.7 * (number // COLUMNS) / (ROWS - 1)
        if isinstance(element, pn.ReferencePlace):
            assert element.target is not None
            target = element.target
            self.hand.click_at("reference place", x, y)
            self.hand.dialog(target=f"{target.name} ({target.page.name})")  # type: ignore[union-attr]
        else:
            self.hand.put(words_for(type(element)), x, y)
        self._fill(element)

    def _sheet(self, page: pn.Page) -> None:
        self.hand.open(page.name or page.id)
        if isinstance(page, sym.NodeNet):
            for signal in page.signals:
                self.hand.button("+ input signal")
                self._fill(signal)
                self._back_to(page)
        for number, each in enumerate(page.objects):
            self._put(each, number)
            if isinstance(each, pn.Transition):
                self._transition(each)
            if isinstance(each, sym.Place):
                self._tokens(each)
            if isinstance(each, pn.Page):
                self._sheet(each)
        self._arcs(page)
        self.hand.page.keyboard.press("Alt+ArrowUp")
        self.hand.on_sheet(page.eContainer().name)  # type: ignore[union-attr]

    def _transition(self, transition: pn.Transition) -> None:
        if isinstance(transition, sym.Transition) and transition.clause is not None:
            self.hand.fill("clause", transition.clause.text)
            self.hand.page.locator(".row:has(#field-clause)").get_by_role("button", name="show").click()
            self.hand.fill("name", transition.clause.name or "")
            self._back_to(transition)
        if transition.interval is not None:
            self.hand.button("+ time interval", group="interval")
            self._fill(transition.interval)
            self._back_to(transition)

    def _back_to(self, element: pn.Element) -> None:
        self.hand.page.locator("#form").get_by_role(
            "button", name=element.name or element.id, exact=True
        ).first.click()

    def _tokens(self, place: sym.Place) -> None:
        for balloon in place.balloons:
            self.hand.button("+ balloon token")
            for name, value in json.loads(balloon.data).items():
                self.hand.fill(f"data-{name}", value)
            self._back_to(place)

    def _arcs(self, page: pn.Page) -> None:
        if not page.arcs:
            return
        self.hand.tool("arc")
        middles = self.hand.middles()
        for arc in page.arcs:
            for end in (arc.source, arc.target):
                assert end is not None
                self.hand.page.mouse.click(*middles[end.id])
            self.hand.idle()
        self.hand.page.keyboard.press("Escape")

    def _channel(self, channel: sym.Channel, number: int) -> None:
        x, y = 0.1 + 0.8 * (number % COLUMNS) / (COLUMNS - 1), 0.12 + 0.7 * (number // COLUMNS) / (ROWS - 1)
        self.hand.click_at(words_for(type(channel)), x, y)
        if isinstance(channel, sym.TopicChannel):
            self.hand.dialog(topic=channel.topic)
            self._fill(channel, "topic")
            for port, kind in [
                *((port, "publisher port") for port in channel.publishers),
                *((port, "subscriber port") for port in channel.subscribers),
            ]:
                self._port(kind, port, channel, "place")
        elif isinstance(channel, sym.ServiceChannel):
            server = channel.server
            assert server is not None
            self.hand.dialog(service=channel.service, **self._ends(server, "entry", "exit", "page"))
            self._fill(channel, "service")
            for client in channel.clients:
                self._port("client port", client, channel, "request", "response", client=client.client)

    def _port(self, words: str, port: EObject, channel: sym.Channel, *ends: str, **more: Any) -> None:
        self.hand.page.get_by_role("button", name=f"+ {words}", exact=True).click()
        self.hand.dialog(**more, **self._ends(port, *ends))
        self._fill(port, *more)
        self._back_to(channel)

    def _ends(self, port: EObject, *names: str) -> dict[str, str]:
        """Return what the dialog calls the places and pages that a port leads to."""
        found = {}
        for name in names:
            end = getattr(port, name)
            above = end.eContainer()
            found[name] = f"{end.name} ({above.name})"
        return found
