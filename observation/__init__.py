"""Systems that exist already: seen or recorded, made into models, compared with models, explained by them."""
