"""`omni.kit.stage_templates`: new stages."""

from __future__ import annotations

from typing import Any

from . import stage

__all__ = ["get_stage_template_list", "new_stage", "new_stage_async", "new_stage_with_callback"]


def get_stage_template_list() -> list[list[str]]:
    return [["empty"], ["sunlight"], ["default stage"]]


def new_stage(template: str = "empty", usd_context: Any = None) -> None:
    stage.create_new_stage(template=template)


async def new_stage_async(template: str = "empty", usd_context: Any = None) -> tuple[bool, str]:
    await stage.create_new_stage_async(template=template)
    return True, ""


def new_stage_with_callback(on_new_stage_fn: Any = None, template: str = "empty", usd_context: Any = None) -> None:
    new_stage(template)
    if on_new_stage_fn is not None:
        on_new_stage_fn(True, "")
