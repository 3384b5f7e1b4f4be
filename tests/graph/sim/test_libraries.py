"""What comes with Open3D and what waits until it is called."""

import subprocess
import sys

DRAW = """
import sys
from graph.sim.libraries import import_open3d

open3d = import_open3d()
assert import_open3d() is open3d
web = [name for name in ("dash", "IPython", "plotly") if name in sys.modules]
assert not web, web
cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector([[0.0, 0.0, 0.0]]))
figure = open3d.visualization.get_plotly_fig([cloud])
print(type(figure).__module__.partition(".")[0])
# As `import open3d` leaves them: functions of the package, the module behind them by its path.
print(open3d.visualization.draw_plotly.__module__, sys.modules["open3d.visualization.draw_plotly"].__name__)
"""


def test_open3d_comes_without_its_web_viewer_which_works_when_it_is_called():
    done = subprocess.run([sys.executable, "-c", DRAW], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["plotly", *["open3d.visualization.draw_plotly"] * 2]
