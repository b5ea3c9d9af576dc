"""Generate the typed API from the `.ecore` files, or check that it is up to date.

``python -m dineros.metamodel.generate`` writes one package per metamodel next to this file;
``--check`` writes nothing and exits 1 when a package differs from what would be written.
pyecoregen walks the metamodels; the template is ours, because its own drops enumeration values
and lower bounds and gives no type hints.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path
from typing import Any

from pyecore import ecore
from pyecore.resources import URI, ResourceSet
from pyecoregen.ecore import EcoreGenerator, EcorePackageModuleTask

HOME = Path(__file__).resolve().parent
METAMODELS = ("pn", "sym", "rtm", "pnm", "trace")

_PYTHON_TYPES = {
    "EString": "str",
    "EInt": "int",
    "EIntegerObject": "int",
    "EDouble": "float",
    "EDoubleObject": "float",
    "EBoolean": "bool",
}
_OBJECT_TYPES = ("EIntegerObject", "EDoubleObject")


def documentation(element: ecore.EModelElement) -> str:
    """Return the GenModel documentation of a metamodel element, or an empty string."""
    annotation = element.getEAnnotation("http://www.eclipse.org/emf/2002/GenModel")
    return annotation.details.get("documentation", "") if annotation else ""


def ordered_features(eclass: ecore.EClass) -> list[ecore.EStructuralFeature]:
    """Return all features of a class, inherited ones first, in the order of the metamodel."""
    features: dict[ecore.EStructuralFeature, None] = {}
    for supertype in eclass.eSuperTypes:
        features.update(dict.fromkeys(ordered_features(supertype)))
    features.update(dict.fromkeys(eclass.eStructuralFeatures))
    return list(features)


def qualified(classifier: ecore.EClassifier, package: ecore.EPackage) -> str:
    """Return the Python name of a classifier as seen from the module of `package`."""
    if classifier.ePackage is package:
        return str(classifier.name)
    if classifier.ePackage.nsURI == ecore.nsURI:
        return str(classifier.name)
    return f"{classifier.ePackage.name}.{classifier.name}"


def value_type(feature: ecore.EStructuralFeature, package: ecore.EPackage) -> str:
    """Return the type hint of one value of a feature, without optionality."""
    return _PYTHON_TYPES.get(feature.eType.name) or qualified(feature.eType, package)


def is_optional(feature: ecore.EStructuralFeature) -> bool:
    """Return whether reading the feature may give None."""
    if feature.lowerBound > 0 or feature.many:
        return False
    if isinstance(feature, ecore.EReference):
        return True
    if feature.defaultValueLiteral is not None:
        return False
    return feature.eType.name in (*_OBJECT_TYPES, "EString")


def type_hint(feature: ecore.EStructuralFeature, package: ecore.EPackage) -> str:
    """Return the type hint of a feature."""
    hint = value_type(feature, package)
    if feature.many:
        return f"ModelList[{hint}]"
    if isinstance(feature.eType, ecore.EEnum):
        return f"Choice[{hint}]"
    if feature.lowerBound > 0 and isinstance(feature, ecore.EReference):
        return f"Mandatory[{hint}]"
    return f"{hint} | None" if is_optional(feature) else hint


def _views(classes: list[ecore.EClass], package: ecore.EPackage) -> list[str]:
    """Return the generic static views that the type hints of a package use, sorted."""
    hints = [type_hint(feature, package) for c in classes for feature in c.eStructuralFeatures]
    return sorted({hint.partition("[")[0] for hint in hints if "[" in hint})


def qualifiers(feature: ecore.EStructuralFeature, package: ecore.EPackage) -> str:
    """Return the arguments of the feature."""
    arguments: dict[str, str] = {}
    parts = []
    if isinstance(feature, ecore.EAttribute):
        enum = isinstance(feature.eType, ecore.EEnum)
        type_name = qualified(feature.eType, package)
        arguments["eType"] = type_name if enum else f"Ecore.{type_name}"
        if feature.iD:
            arguments["iD"] = "True"
        if feature.defaultValueLiteral is not None:
            value = feature.eType.from_string(feature.defaultValueLiteral)
            arguments["default_value"] = f"{type_name}.{value}" if enum else repr(value)
    else:
        parts.append(repr(qualified(feature.eType, package)))
        other = feature.eOpposite
        if other is not None and _path(other) > _path(feature):  # one of the two names the other
            arguments["opposite"] = repr(other.name)
        if feature.containment:
            arguments["containment"] = "True"
    if feature.lowerBound:
        arguments["lower"] = str(feature.lowerBound)
        arguments["required"] = "True"
    if feature.upperBound != 1:
        arguments["upper"] = str(feature.upperBound)
    if feature.transient:
        arguments["transient"] = "True"
    return ", ".join([*parts, *(f"{name}={value}" for name, value in arguments.items())])


def _path(feature: ecore.EStructuralFeature) -> str:
    return f"{feature.eContainingClass.name}.{feature.name}"


def wrap(text: str, indent: int) -> str:
    """Wrap running text at 110 columns, following lines indented."""
    return textwrap.fill(text, 106 - indent).replace("\n", "\n" + " " * indent)


def docstring(element: ecore.EModelElement, indent: int) -> str:
    """Return the documentation of an element as a docstring; after several lines, the quotes have a line."""
    text = wrap(documentation(element), indent)
    end = "\n" + " " * indent if "\n" in text else ""
    return f'"""{text}{end}"""'


class TypedModule(EcorePackageModuleTask):
    """One Python module per metamodel."""

    template_name = "module.py.j2"

    @staticmethod
    def filename_for_element(package: ecore.EPackage) -> str:
        """Return the file name of the module of a package."""
        return "__init__.py"

    def create_template_context(self, element: ecore.EPackage, **_: Any) -> dict[str, Any]:
        """Return what the template reads: the package, its classes in order of inheritance, its imports."""
        classes = [c for c in element.eClassifiers if isinstance(c, ecore.EClass)]
        classes.sort(key=lambda c: len(set(c.eAllSuperTypes())))
        used = {
            feature.eType.ePackage.name
            for c in classes
            for feature in ordered_features(c)
            if feature.eType.ePackage is not element
        }
        used |= {s.ePackage.name for c in classes for s in c.eSuperTypes if s.ePackage is not element}
        context: dict[str, Any] = super().create_template_context(element)
        context.update(
            classes=classes,
            imports=sorted(used - {"ecore"}),
            views=_views(classes, element),
            enumerations=[c for c in element.eClassifiers if isinstance(c, ecore.EEnum)],
        )
        return context


class TypedGenerator(EcoreGenerator):
    """pyecoregen's generator with the template of this folder."""

    templates_path = str(HOME / "templates")

    def __init__(self) -> None:
        super().__init__()
        self.tasks = [TypedModule()]
        environment = self.create_environment(
            trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
        )
        for task in self.tasks:
            task.environment = environment
            task.global_context = self.create_global_context()

    def create_environment(self, **kwargs: Any) -> Any:
        """Return the Jinja environment with our filters."""
        environment = super().create_environment(**kwargs)
        environment.filters.update(
            docstring=docstring,
            documentation=documentation,
            type_hint=type_hint,
            qualifiers=qualifiers,
            qualified=qualified,
            wrap=wrap,
        )
        return environment


def generate(folder: Path) -> list[Path]:
    """Write the typed API of all metamodels into `folder`; return the files, formatted."""
    resources = ResourceSet()
    files = []
    for name in METAMODELS:
        package = resources.get_resource(URI(str(HOME / f"{name}.ecore"))).contents[0]
        TypedGenerator().generate(package, str(folder))
        files.append(folder / name / "__init__.py")
    ruff = [sys.executable, "-P", "-m", "ruff"]
    configuration = ["--config", str(HOME.parent / "pyproject.toml")]
    paths = [str(file) for file in files]
    subprocess.run([*ruff, "check", "-q", "--fix", "--select", "I,F401", *configuration, *paths], check=False)
    subprocess.run([*ruff, "format", "-q", *configuration, *paths], check=True)
    return files


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 when a package is stale")
    if not parser.parse_args(arguments).check:
        generate(HOME)
        return 0
    with tempfile.TemporaryDirectory() as scratch:
        stale = [
            fresh.parent.name
            for fresh in generate(Path(scratch))
            if not (HOME / fresh.parent.name / fresh.name).exists()
            or fresh.read_bytes() != (HOME / fresh.parent.name / fresh.name).read_bytes()
        ]
    for name in stale:
        print(f"metamodel/{name}/__init__.py is stale: run 'make regenerate'", file=sys.stderr)
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
