"""The form of a PNML file as a whole: the namespace of its elements, its one net, and the net's type."""

from __future__ import annotations

from lxml import etree

from dineros.metamodel.errors import counted
from dineros.metamodel.files.pnml.plain.known import BESIDE_NET, MEANINGS
from dineros.metamodel.files.pnml.source import Source, children, local
from dineros.metamodel.files.pnml.vocabulary import DINEROS, OWN, PNML, PTNET, tag

_PLAIN_TYPES = frozenset(
    {
        *("ptnet", "pnmlcoremodel", "pnmlcore", "ptnetb", "p/t net", "pt net", "place/transition net", "ptn"),
        *("epnml-1.1", "epnml", "tpn", "inhibitorptnet", "resetptnet", "resetinhibitorptnet"),
    }
)
"""Last parts of types of nets without colours, in lower case; what they add is read or refused elsewhere."""
_REFERRING = ("id", "source", "target", "ref", "idref")
"""Attributes that hold ids."""
_SYMMETRIC = ("symmetricnet", "pt-hlpng")
"""Coloured nets that are unfolded; places of the second have one colour only."""
_COLOURED = ("symmetricnet", "highlevelnet", "hlpng", "pt-hlpng", "hlnet", "coloured", "colored")


def only_net(root: etree._Element, source: Source) -> etree._Element:
    """Return the one net of a file, after all PNML elements were put into the namespace of 2009.

    Raises
    ------
    ModelFileError
        The file is not PNML, holds no net or several, or its net has a type with colours or an unknown one.
    """
    if local(root) != "pnml":
        hint = f'the root is <pnml xmlns="{PNML}">'
        raise source.error(f"is not PNML: the root is <{local(root)}>{_namespace(root)}", root, hint=hint)
    _adopt(root, source)
    nets = [inner for inner in children(root) if inner.tag == tag("net")]
    if len(nets) != 1:
        where = nets[1] if nets else root
        raise source.error(f"holds {len(nets) or 'no'} nets", where, hint="a model is one <net>")
    for inner in children(root):
        if local(inner) not in BESIDE_NET:
            hint = MEANINGS.get(local(inner), "remove it if it does not describe the net")
            source.complain(f"<{local(inner)}> is not known next to the net", inner, hint=hint)
        elif local(inner) == "feature" and inner.get("isColored", "").strip().lower() == "true":
            source.complain("the net is coloured", inner, hint="only P/T nets are read; unfold it first")
    if not is_symmetric(nets[0]):
        _check_type(nets[0], source)
        _replace_ids_with_blanks(nets[0], source)
    return nets[0]


def is_symmetric(net: etree._Element) -> bool:
    """Return whether a net is a coloured net that is unfolded when it is read."""
    return _last_part(net) in _SYMMETRIC


def _adopt(root: etree._Element, source: Source) -> None:
    """Put elements without a namespace, or in that of the root, into the namespace of 2009."""
    own = etree.QName(root).namespace
    if own == PNML and next(root.iter("{}*"), None) is None:
        return
    foreign = {own, None} - {PNML}
    todo = [root]
    adopted: set[str | None] = set()
    while todo:
        xml = todo.pop()
        name = etree.QName(xml)
        if name.namespace in foreign:
            adopted.add(name.namespace)
            xml.tag = tag(name.localname)
        if name.localname != "toolspecific":  # what is in it is its tool's
            todo.extend(children(xml))
    for namespace in sorted(adopted, key=str):
        source.note("no namespace" if namespace is None else f"namespace {namespace!r}")


def _replace_ids_with_blanks(net: etree._Element, source: Source) -> None:
    """Replace ids with white space, which other tools make of names; the names keep it."""
    elements = [net]
    for xml in elements:
        if local(xml) == "toolspecific":
            if xml.get("tool") in (DINEROS, OWN):
                return  # our own blocks refer to ids, too
            continue
        elements.extend(children(xml))
    known = {id for xml in elements if (id := xml.get("id"))}
    replaced: dict[str, str] = {}
    for id in sorted(known):
        if (words := id.split()) and words != [id]:
            plain = "_".join(words)
            replaced[id] = next(
                each
                for each in (plain, *(f"{plain}_{number}" for number in range(2, len(known) + 3)))
                if each not in known
            )
            known.add(replaced[id])
    if not replaced:
        return
    for xml in elements:
        for name in _REFERRING:
            if (old := xml.get(name)) in replaced:
                xml.set(name, replaced[old])
    shown, plain = next(iter(replaced.items()))
    source.note(f"{counted(len(replaced), 'id')} with white space replaced, such as {shown!r} by {plain!r}")


def _namespace(xml: etree._Element) -> str:
    namespace = etree.QName(xml).namespace
    return f" in the namespace {namespace!r}" if namespace else " without a namespace"


def _check_type(net: etree._Element, source: Source) -> None:
    kind = (net.get("type") or "").strip()
    if kind == PTNET:
        return
    last = _last_part(net)
    if not kind:
        source.note("no net type")
    elif last in _PLAIN_TYPES:
        source.note(f"net type {kind!r}")
    else:
        hint = f"P/T nets are {PTNET}"
        if any(part in last for part in _COLOURED):
            hint = f"it has coloured tokens; unfold it first: P/T nets are {PTNET}"
        raise source.error(f"the net type {kind!r} is not supported", net, hint=hint)


def _last_part(net: etree._Element) -> str:
    """Return the text that states the type of a net, in lower case."""
    lower = (net.get("type") or "").strip().lower().rstrip("/").removesuffix(".pntd")
    return lower if lower in _PLAIN_TYPES else lower.rpartition("/")[2]
