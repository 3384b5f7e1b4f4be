"""JSON Schema of the file format, for editors."""

from __future__ import annotations

from typing import Any

from . import model


def json_schema() -> dict[str, Any]:
    """The schema (draft 2020-12) of graph files, made from the models that check them."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **model.GraphFile.model_json_schema(mode="validation"),
        "title": "TickGraph graph file",
    }
