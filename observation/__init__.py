"""Systems that exist already: what runs or was recorded, made into models, compared with models, and explained by them."""
