"""Tables for notebooks."""
from __future__ import annotations

import html
from typing import Any, Mapping


def table(rows: Mapping[str, Any]) -> str:
    """An HTML table of names and values."""
    lines = (f"<tr><th>{html.escape(name)}</th><td>{html.escape(str(value))}</td></tr>"
             for name, value in rows.items())
    return f"<table>{''.join(lines)}</table>"
