"""Results as files, pictures and charts. Viewers are imported by the functions that use them."""

from skancf.atomic import check_folder
from skancf.output.adaptive_charts import convergence, effectivity, mesh_levels
from skancf.output.charts import field_chart, histories_chart, mesh_chart
from skancf.output.files import read, write
from skancf.output.films import animation
from skancf.output.panels import draw_cells
from skancf.output.pictures import picture, plot
from skancf.output.sampling import Samples, sample
from skancf.output.spectrum_chart import spectrum_chart
from skancf.output.style import Style
from skancf.output.tables import save_table
from skancf.output.viewer import view
from skancf.output.web import write_html
from skancf.tabular import Columns
from skancf.tensors import principal_directions, principal_stresses, signed_von_mises, tresca, von_mises

__all__ = [
    "Columns",
    "Samples",
    "Style",
    "animation",
    "check_folder",
    "convergence",
    "draw_cells",
    "effectivity",
    "field_chart",
    "histories_chart",
    "mesh_chart",
    "mesh_levels",
    "picture",
    "plot",
    "principal_directions",
    "principal_stresses",
    "read",
    "sample",
    "save_table",
    "signed_von_mises",
    "spectrum_chart",
    "tresca",
    "view",
    "von_mises",
    "write",
    "write_html",
]
