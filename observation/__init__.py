"""Systems that exist already: what is seen of them is made into models, and compared with models."""
