"""The subcommands: module ``check`` holds the command ``check``, made by `dineros.cli.options.command`.

A module imports only click and `dineros.cli` at its top, and everything else where it is used:
``dineros --help`` reads all modules.
"""
