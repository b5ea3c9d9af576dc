# mypy: disable-error-code="import-untyped"
"""Installs the simulated cell as a ROS package."""

from setuptools import setup

setup(
    name="sorting_cell",
    version="0.1.0",
    packages=["sorting_cell"],
    package_data={"sorting_cell": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/sorting_cell"]),
        ("share/sorting_cell", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    extras_require={"test": ["pytest"]},
    entry_points={"console_scripts": ["cell = sorting_cell.simulator:main"]},
)
