"""The command line ``dineros``: one thin module per subcommand in `commands`."""
