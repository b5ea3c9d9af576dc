"""The live page: a running application followed on 127.0.0.1."""

from dineros.views.live.serving import LiveHandle, serve_live

__all__ = ["LiveHandle", "serve_live"]
