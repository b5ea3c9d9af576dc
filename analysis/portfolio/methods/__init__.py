"""The decision methods, one class per module; `portfolio.plans` defines when each is used."""
