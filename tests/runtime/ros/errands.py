"""A runner who does errands for a boss: an action of a generated type, and one of an existing type."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.build import flow

MAPPED = [
    sym.FieldMapping(part=part, messageField=f"token.{field}", tokenField=field)
    for part in ("goal", "result", "feedback")
    for field in ("number", "place")
]


def errands(goals: int = 0, outstanding: int = 1) -> sym.SystemModel:
    """Return the system.

    Parameters
    ----------
    goals : int
        Tokens of the boss for each action: errands to send, numbered from 1.
    outstanding : int
        Errands that he has under way at most.
    """
    model = sym.SystemModel(
        id="errands",
        middleware="ros2",
        tokenType=sym.TokenType(
            id="Job",
            fields=[
                sym.TokenField(name="number", kind="integer"),
                sym.TokenField(name="place"),
            ],
        ),
    )
    model.pages.extend([sym.NodeNet(id="runner"), sym.NodeNet(id="boss")])
    model.channels.append(_action(model, "Errand", "/errand", goals, outstanding))
    chore = _action(model, "Chore", "/chore", goals, outstanding, slots=1, rejects=True)
    chore.type = "errands_interfaces/action/Errand"
    chore.mappings.extend(
        sym.FieldMapping(part=each.part, messageField=each.messageField, tokenField=each.tokenField)
        for each in MAPPED
    )
    model.channels.append(chore)
    return model


def _action(
    model: sym.SystemModel,
    name: str,
    action: str,
    goals: int,
    outstanding: int,
    *,
    slots: int = 2,
    rejects: bool = False,
) -> sym.ActionChannel:
    runner, boss = model.pages
    page = sym.CallbackPage(id=f"Do{name}", kind="goal", page=runner)
    places = {
        word: sym.Place(id=f"{word}{name}", page=page)
        for word in ("Asked", "Running", "Told", "Done", "Broken", "Stop", "Stopped")
    }
    begin, end, fail, stop = (
        sym.Transition(id=f"T{word}{name}", page=page) for word in ("Begin", "End", "Fail", "Stop")
    )
    flow(places["Asked"], begin, places["Running"])
    flow(begin, places["Told"])
    flow(places["Running"], end, places["Done"])
    flow(places["Running"], fail, places["Broken"])
    flow(places["Running"], stop, places["Stopped"])
    flow(places["Stop"], stop)
    server = sym.ActionServerPort(
        page=page,
        entry=places["Asked"],
        succeeded=places["Done"],
        aborted=places["Broken"],
        canceled=places["Stopped"],
        cancel=places["Stop"],
        feedback=places["Told"],
        mayReject=rejects,
    )
    own = {
        word: sym.Place(id=f"{word}{name}", page=boss)
        for word in ("Wish", "Sent", "Fine", "Failed", "Recalled", "Refused", "Recall", "News", "Noted")
    }
    own["Wish"].tokens = goals
    own["Wish"].balloons.extend([sym.BalloonToken(data=f'{{"number": {n}}}') for n in range(1, goals + 1)])
    flow(own["Wish"], sym.Transition(id=f"TSend{name}", page=boss), own["Sent"])
    flow(own["News"], sym.Transition(id=f"TNote{name}", page=boss), own["Noted"])
    flow(own["News"], sym.Transition(id=f"TRecall{name}", page=boss), own["Recall"])
    client = sym.ActionClientPort(
        client="boss",
        goal=own["Sent"],
        succeeded=own["Fine"],
        aborted=own["Failed"],
        canceled=own["Recalled"],
        rejected=own["Refused"],
        cancel=own["Recall"],
        feedback=own["News"],
        outstanding=outstanding,
    )
    return sym.ActionChannel(id=name, action=action, instances=slots, server=server, clients=[client])
