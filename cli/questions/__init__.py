"""Questions that commands ask about models, from the options to what is told of the answer."""
