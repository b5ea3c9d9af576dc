"""Questions of commands about models, from the options to the printed answer."""
