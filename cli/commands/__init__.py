"""The subcommands: module ``check`` has the command ``check``, defined by `dineros.cli.options.command`.

A module imports only click and `dineros.cli` at its top, and everything else where it is used:
``dineros --help`` reads all modules.
"""
