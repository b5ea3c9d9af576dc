"""The methods of deciding, a class in each module; `portfolio.plans` says when each is asked."""
