"""A server of a page that says one word."""

from __future__ import annotations

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route
from starlette.types import ASGIApp

from dineros.views.serving.entrance import Entrance
from dineros.views.serving.handle import PageHandle, serve_page


def small_page(door: Entrance) -> ASGIApp:
    async def page(request: Request) -> Response:
        return door.page(request, ("page", "default-src 'none'") if door.lets_in(request) else None)

    return Starlette(routes=[Route("/", page)])


def serve_small_page() -> PageHandle:
    return serve_page(small_page, None, 0, what="the page", longest_message=100)
