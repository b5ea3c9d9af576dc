"""The live page: a running application followed on 127.0.0.1."""

from dineros.views.live.serving import serve_live
from dineros.views.live.steering import Steering

__all__ = ["Steering", "serve_live"]
