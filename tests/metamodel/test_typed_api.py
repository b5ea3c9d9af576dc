"""The generated classes say what the `.ecore` files say, and refuse what they do not know."""

import importlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pyecore import ecore
from pyecore.notification import EObserver
from pyecore.resources import URI, ResourceSet

from dineros.metamodel import generate, pn, sym
from dineros.metamodel.errors import DinerosError, FeatureValueError, UnknownFeatureError

FOLDER = Path(generate.__file__).parent


def metamodels() -> Iterator[tuple[Any, Any]]:
    resources = ResourceSet()
    for name in generate.METAMODELS:
        package = resources.get_resource(URI(str(FOLDER / f"{name}.ecore"))).contents[0]
        yield package, importlib.import_module(f"dineros.metamodel.{name}")


CLASSES = [
    pytest.param(classifier, module, id=f"{package.name}.{classifier.name}")
    for package, module in metamodels()
    for classifier in package.eClassifiers
]


def describe(feature: Any) -> dict[str, Any]:
    """Everything of a feature that a model can notice."""
    found = {
        "type": feature.eType.__name__ if isinstance(feature.eType, type) else feature.eType.name,
        "lower": feature.lowerBound,
        "upper": feature.upperBound,
        "transient": feature.transient,
    }
    if isinstance(feature, ecore.EReference):
        found["containment"] = feature.containment
        found["opposite"] = feature.eOpposite.name if feature.eOpposite else None
    else:
        found["iD"] = bool(feature.iD)
        found["default"] = str(feature.get_default_value())
    return found


@pytest.mark.parametrize(("classifier", "module"), CLASSES)
def test_generated_class_equals_the_metamodel(classifier: Any, module: Any) -> None:
    generated = getattr(module, classifier.name)
    if isinstance(classifier, ecore.EEnum):
        assert [(literal.name, literal.value) for literal in generated.eLiterals] == [
            (literal.name, literal.value) for literal in classifier.eLiterals
        ]
        return
    assert generated.eClass.abstract == classifier.abstract
    supertypes = {supertype.name for supertype in generated.eClass.eAllSuperTypes()}
    assert supertypes == {supertype.name for supertype in classifier.eAllSuperTypes()}
    assert {f.name: describe(f) for f in generated.eClass.eStructuralFeatures} == {
        f.name: describe(f) for f in classifier.eStructuralFeatures
    }


def test_the_committed_api_is_up_to_date() -> None:
    assert generate.main(["--check"]) == 0


def test_a_stale_api_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    home = tmp_path / "metamodel"
    for name in generate.METAMODELS:
        (home / name).mkdir(parents=True)
        text = (FOLDER / name / "__init__.py").read_bytes()
        (home / name / "__init__.py").write_bytes(text + (b"# edited\n" if name == "sym" else b""))
    for file in FOLDER.glob("*.ecore"):
        (home / file.name).write_bytes(file.read_bytes())
    (tmp_path / "pyproject.toml").write_bytes((FOLDER.parent / "pyproject.toml").read_bytes())
    monkeypatch.setattr(generate, "HOME", home)
    assert generate.main(["--check"]) == 1
    assert "metamodel/sym/__init__.py is stale" in capsys.readouterr().err


def test_unknown_features_are_refused_with_near_matches() -> None:
    place = sym.Place(id="p")
    with pytest.raises(UnknownFeatureError, match=r"Place has no feature 'tokns' .did you mean 'tokens'"):
        place.tokns = 3  # type: ignore[attr-defined]
    with pytest.raises(UnknownFeatureError, match="did you mean 'tokens'"):
        sym.Place(id="p", tokns=3)  # type: ignore[call-arg]
    assert "tokns" not in vars(place)


def test_wrong_values_are_refused() -> None:
    place = sym.Place(id="p", tokens=2)
    with pytest.raises(FeatureValueError, match=r"Place\.tokens takes EInt, not 'x'"):
        place.tokens = "x"  # type: ignore[assignment]
    with pytest.raises(FeatureValueError, match=r"Page\.objects takes a list of PageObject, not list"):
        pn.Page(id="page", objects=[pn.Net(id="n")])  # type: ignore[list-item]
    assert place.tokens == 2


def test_enumerations_may_be_given_by_name() -> None:
    arc = pn.Arc(id="a", kind="inhibitor")
    assert arc.kind is pn.ArcKind.inhibitor
    with pytest.raises(
        FeatureValueError, match=r"kind must be one of normal, inhibitor, read, not 'inhibiter'"
    ):
        arc.kind = "inhibiter"


def test_whole_numbers_are_numbers() -> None:
    point = pn.Point(x=1, y=2.5)
    assert (point.x, point.y) == (1.0, 2.5)
    assert isinstance(point.x, float)
    with pytest.raises(FeatureValueError, match=r"Point\.x takes EDouble, not '1'"):
        point.x = "1"  # type: ignore[assignment]


def test_abstract_classes_cannot_be_made() -> None:
    with pytest.raises(TypeError, match="abstract"):
        pn.Node(id="n")


def test_errors_are_one_family_and_one_line() -> None:
    assert issubclass(UnknownFeatureError, DinerosError)
    assert issubclass(FeatureValueError, DinerosError)
    assert "\n" not in str(DinerosError("two\nlines", hint="and\na hint"))


def test_opposites_and_containers_follow() -> None:
    page = pn.Page(id="page")
    place, transition = pn.Place(id="p", page=page), pn.Transition(id="t", page=page)
    arc = pn.Arc(id="a", source=place, target=transition, page=page)
    assert list(page.objects) == [place, transition]
    assert list(place.outgoing) == [arc] == list(transition.incoming)
    assert repr(place) == "<pn.Place p>"


def test_listeners_of_objects_and_resources_hear_of_changes(tmp_path: Path) -> None:
    heard: list[tuple[str, object]] = []
    observer = EObserver(notifyChanged=lambda change: heard.append((change.feature.name, change.new)))
    place = pn.Place(id="p", tokens=1)
    place.tokens = 2
    observer.observe(place)
    place.tokens = 3
    assert heard == [("tokens", 3)]
    net = pn.Net(id="n", pages=[pn.Page(id="page", objects=[other := pn.Place(id="other")])])
    resource = ResourceSet().create_resource(URI(str(tmp_path / "net.xmi")))
    resource.append(net)
    observer.observe(resource)
    other.tokens = 4
    assert heard[1:] == [("tokens", 4)]
    assert not pn.Place.eClass.eAllOperations()


def test_listeners_see_the_attributes_of_a_new_object() -> None:
    heard: list[str] = []
    page = pn.Page(id="page")
    EObserver(page, notifyChanged=lambda change: heard.append(change.new.id))
    pn.Place(page=page, id="p")
    pn.Arc(page=page, id="a", kind="read")
    assert heard == ["p", "a"]
