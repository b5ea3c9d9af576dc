"""Rules as data: the rule language, its matcher, and the rules that flatten and split system models."""

from dineros.metamodel.moved import find_moved

find_moved(__name__)
