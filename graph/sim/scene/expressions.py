"""Asset paths that are variable expressions, such as @`"./${ROBOT}.usda"`@.

USD evaluates them with the variables of the root layer of a layer stack (`expressionVariables`), overridden by those of
the layer stacks that reference it. So the result depends on the path by which the layer was reached.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Variables = Mapping[str, Any]
"""The variables of a layer stack by name: texts, numbers, truths and lists."""


def stack_variables(layer: Any, above: Variables) -> Variables:
    """The variables of the layer stack with root `layer` (`Sdf.Layer`), overridden by those `above`."""
    own = layer.expressionVariables
    return {**own, **above} if own else above


def as_key(variables: Variables) -> str:
    """Equal for equal variables."""
    return repr(sorted((name, repr(value)) for name, value in variables.items())) if variables else ""


def evaluated(asset: str, variables: Variables) -> tuple[str, str]:
    """The path that an asset path evaluates to, and an error message if there is no path.

    A plain path is returned unchanged, without a message. The path is "" if the expression is empty or wrong.
    """
    from graph.sim.usd import Sdf

    if not Sdf.VariableExpression.IsExpression(asset):
        return asset, ""
    result = Sdf.VariableExpression(asset).Evaluate(dict(variables))
    if result.errors:
        return "", f"the variable expression {asset} is wrong: {'; '.join(result.errors)}"
    if result.value is None or result.value == "":
        return "", ""
    if not isinstance(result.value, str):
        return "", f"the variable expression {asset} gives {result.value!r}, which is not a path"
    unset = sorted(set(result.usedVariables) - set(variables))
    why = f"; no expressionVariables give {', '.join(unset)}" if unset else ""
    return result.value, f"{result.value} does not exist (the variable expression {asset}{why})"
