"""The table of the links, which a person sorts by a click on a heading."""

from bokeh.models import ColumnDataSource, CustomJS, DataTable, NumberFormatter, StringFormatter, TableColumn

from console.measures import reception
from console.terminal.formatting import UNKNOWN
from console.web import columns
from fes.protocol.report import Report

_LENGTH, _SIGNED, _SHARE, _COUNT = "0.00", "+0.00", "0.0%", "0,0"

FIELDS = {
    "separation": ("separation [m]", _LENGTH),
    "error": ("error [m]", _SIGNED),
    "estimate_a": ("est. a [m]", _LENGTH),
    "estimate_b": ("est. b [m]", _LENGTH),
    "outage": ("outage", _SHARE),
    "decoded": ("decoded", _SHARE),
    "learnt": ("learnt", _SHARE),
    "true": ("true", _SHARE),
    "sent": ("sent", _COUNT),
    "gap": ("gap", _COUNT),
}
"""Headings and formats of the columns after the first."""

OF_MEASURED = ("learnt", "true")
"""Columns of a measured run only."""

REDRAW = "setTimeout(() => view.change.emit())"
"""Script of the browser. A table of Bokeh draws new numbers by itself only if the number of rows changes."""


class LinkTable:
    """One row per link in use."""

    def __init__(self) -> None:
        self._source = ColumnDataSource({name: [] for name in ("link", *FIELDS)}, name="table")
        self._columns = {name: _column(name, heading, form) for name, (heading, form) in FIELDS.items()}
        link = TableColumn(field="link", title="link a–b", formatter=StringFormatter(), width=60)
        self.table = DataTable(
            name="link_table",
            source=self._source,
            columns=[link, *self._columns.values()],
            index_position=None,
            sizing_mode="stretch_both",
            min_height=150,
            row_height=22,
            reorderable=False,
        )
        self._source.js_on_change("data", CustomJS(args={"view": self.table.view}, code=REDRAW))

    def show(self, report: Report) -> None:
        """Show a report; the sorting stays."""
        self._source.data = columns.table(report)
        for name in OF_MEASURED:
            self._columns[name].visible = reception.is_measured(report)


def _column(name: str, heading: str, form: str) -> TableColumn:
    formatter = NumberFormatter(format=form, nan_format=UNKNOWN, text_align="right")
    width, visible = 24 + 7 * len(heading), name not in OF_MEASURED
    return TableColumn(field=name, title=heading, formatter=formatter, width=width, visible=visible)
