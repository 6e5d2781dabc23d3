"""What draws on others' plotters and axes, the viewer and its page, films, and curved cells."""

import base64
import json
import os
import re
import shutil
import sys
import zlib

import numpy as np
import pytest

import skancf as sk
from skancf import output
from skancf.output import films, viewer
from skancf.output.colours import colour_limits
from skancf.output.fields import values
from skancf.output.reels import reel_of
from skancf.output.shows import Look, Show
from skancf.output.viewer import Window
from skancf.output.web import page_of

MODES = 3


@pytest.fixture(scope="module")
def strip():
    problem = sk.Problem(sk.Rectangle(1.0, 0.3), 0.01, sk.Isotropic(2e9, 0.3, 1e3), [sk.Clamp("left")],
                         [sk.EdgeLoad("right", (0.0, 0.0, -1.0))])  # fmt: skip
    return problem.on(sk.meshes.uniform(problem.surface, 3, 2), "kirchhoff")


@pytest.fixture(scope="module")
def bent(strip):
    return sk.solve_linear(strip)


@pytest.fixture(scope="module")
def modes(strip):
    return sk.modes(strip, MODES)


@pytest.fixture(scope="module")
def motion(strip):
    return sk.simulate(strip, 0.03, dt=0.01, outputs=4, progress=False)


# Plotters and axes


def test_a_plot_is_drawn_on_a_panel_of_the_users_own(bent, modes):
    import pyvista

    plotter = pyvista.Plotter(shape=(1, 2), off_screen=True, window_size=(400, 150))
    places = []
    for k, state in enumerate((bent, modes.shape(1))):
        plotter.subplot(0, k)
        assert output.plot(state, plotter, field="u3") is plotter
        places.append(plotter.camera.position)
    # Each panel has a bar of its own, though both mean u3, and a camera of its own.
    assert len(plotter.scalar_bars) == 2 and places[0] != places[1]
    # What is added to a panel that is not empty leaves its camera.
    plotter.camera.position = (9.0, 9.0, 9.0)
    output.plot(bent, plotter, field="u1")
    assert plotter.camera.position == (9.0, 9.0, 9.0)
    image = plotter.screenshot(return_img=True)
    assert image.shape == (150, 400, 3) and all(half.std() > 5 for half in np.split(image, 2, axis=1))
    plotter.close()


def test_what_is_no_plotter_is_refused(bent):
    for wrong in ("plotter", 3, output):
        with pytest.raises(sk.InputError, match=r"plotter = .*pyvista\.Plotter"):
            output.plot(bent, wrong)
    with pytest.raises(sk.InputError, match="off_screen = 'no'"):
        output.plot(bent, off_screen="no")


def charts(mesh):
    """Every chart, as a function of the path and the axes."""
    t = np.linspace(0.0, 1.0, 5)
    curve = {"a": ([10.0, 100.0], [0.1, 0.01])}
    spectrum = sk.spectrum(np.linspace(0, 1, 64), np.sin(60 * np.linspace(0, 1, 64)))
    return {
        "mesh": lambda **where: output.mesh_chart(mesh, **where),
        "field": lambda **where: output.field_chart(mesh, mesh.p[0], label="u (m)", **where),
        "histories": lambda **where: output.histories_chart(t, {"a": t**2}, ylabel="u3 (m)", **where),
        "convergence": lambda **where: output.convergence(curve, slopes=(-1,), **where),
        "effectivity": lambda **where: output.effectivity({"a": ([10.0], [1.0])}, **where),
        "spectrum": lambda **where: output.spectrum_chart(spectrum, **where),
    }


@pytest.mark.parametrize("name", ["mesh", "field", "histories", "convergence", "effectivity", "spectrum"])
def test_charts_return_axes_to_draw_on(strip, tmp_path, name):
    from matplotlib import pyplot

    chart = charts(strip.geometry.mesh)[name]
    figure, given = pyplot.subplots()
    try:
        assert chart(ax=given) is given and len(given.get_children()) > 10
        new = chart()
        assert new.figure is not figure and new.figure in map(pyplot.figure, pyplot.get_fignums())
        # With a path the file is written, of given axes too, and no window of pyplot is left.
        before = pyplot.get_fignums()
        assert chart(path=tmp_path / "new.png") == tmp_path / "new.png"
        assert pyplot.get_fignums() == before
        assert chart(path=tmp_path / "on.png", ax=given).stat().st_size > 2000
        with pytest.raises(sk.InputError, match=r"ax = .*axes of matplotlib"):
            chart(ax=figure)
    finally:
        pyplot.close("all")


def test_charts_of_several_panels_return_all_axes(strip):
    from matplotlib import pyplot

    mesh, t = strip.geometry.mesh, np.linspace(0.0, 1.0, 5)
    try:
        assert output.histories_chart(t, {name: {"a": t} for name in "pqr"}, ylabel="u").shape == (3,)
        with pytest.raises(sk.InputError, match="ax: one panel, but histories has 3"):
            output.histories_chart(t, {name: {"a": t} for name in "pqr"}, ylabel="u", ax=pyplot.figure().subplots())
        figure, given = pyplot.subplots(1, 2)
        assert list(output.mesh_levels([mesh, mesh], ax=given)) == list(given) and len(figure.axes) == 3
        assert output.mesh_levels([mesh]).shape == (1,)
        with pytest.raises(sk.InputError, match="ax: 2 for 1 meshes"):
            output.mesh_levels([mesh], ax=given)
    finally:
        pyplot.close("all")


# States, and what is shown of them


def test_a_mode_swings_as_a_sine(strip, modes):
    swing = modes.swing(1, size=0.2, frames=8)
    far = modes.shape(1, size=0.2)
    for k, state in enumerate(swing):
        np.testing.assert_allclose(state.change, np.sin(2 * np.pi * k / 8) * far.change, rtol=0, atol=1e-15)
    assert np.linalg.norm(swing[2].displacements, axis=0).max() == pytest.approx(0.2)
    pressed = sk.Problem(strip.problem.surface, 0.01, strip.problem.material, [sk.Clamp("left")],
                         [sk.EdgeLoad("right", (-1.0, 0.0, 0.0))])  # fmt: skip
    found = sk.buckling(pressed.on(strip.geometry.mesh, "kirchhoff"), 1)
    np.testing.assert_array_equal(found.swing(0, frames=4)[1].q, found.shape(0).q)
    with pytest.raises(sk.InputError, match="frames = 1"):
        modes.swing(0, frames=1)


def test_states_of_everything_have_names(bent, modes, motion):
    assert reel_of(bent).names == ("",)
    assert reel_of(motion).names == ("t = 0 s", "t = 0.01 s", "t = 0.02 s", "t = 0.03 s") and reel_of(motion).label == "time"
    found = reel_of(modes)
    assert found.label == "mode" and found.names[2] == f"mode 2, {modes.frequencies[2]:.4g} Hz" and found.rest is modes.state
    half = found.at(1, 30.0)
    np.testing.assert_allclose(half.change, 0.5 * found.at(1).change, rtol=0, atol=1e-15)
    assert reel_of([bent, bent]).names == ("state 0", "state 1")
    for wrong, message in [(3, "states = 3"), ([], "is empty"), ([bent, 1], r"states\[1\] = 1"), ("abc", "states = 'abc'")]:
        with pytest.raises(sk.InputError, match=message):
            reel_of(wrong)


def test_a_show_draws_what_is_chosen(motion, modes):
    show = Show(motion, field="u3")
    assert show.first == Look(state=3, field="u3") and "velocity" in show.fields and "S13" not in show.fields
    states = list(motion.states)
    extremes = np.concatenate([values(state, "u3", 3, None) for state in states])
    assert show.limits(show.first) == colour_limits(extremes.min(), extremes.max())
    frame = show.frame(Look(state=1, field="S11", face="bottom", scale=3.0))
    assert frame.title.startswith("stress S11, bottom face") and "t = 0.01 s" in frame.title
    k = round(np.sqrt(len(frame.points) / states[1].system.geometry.n_elements)) - 1
    np.testing.assert_array_equal(frame.values, values(states[1], "S11", k, "bottom"))
    sample = output.sample(states[1], k, "bottom")
    np.testing.assert_allclose(frame.points, sample.points + 2 * sample.displacement, atol=1e-12)
    # A mode has colours of its own, for both ends of its swing.
    swing = Show(modes)
    low, high = swing.limits(Look(state=1, field="u3"))
    assert low == -high == -np.abs(values(modes.shape(1), "u3", 3, None)).max()
    assert (
        swing.limits(Look(state=2, field="S11")) != swing.limits(Look(state=1, field="S11"))
        and swing.limits(Look(state=1))[0] == 0
    )
    assert np.abs(swing.frame(Look(state=1, phase=180.0)).values).max() < 1e-15


def drawn(window):
    return window.plotter.screenshot(return_img=True).astype(float)


def test_the_window_follows_its_sliders(modes):
    window = Window(Show(modes, field="u3", size=(420, 300)), off_screen=True)
    before = drawn(window)
    for name, value, choice in [("phase", 270.0, 270.0), ("state", 1.3, 1), ("field", 5.2, window.show.fields[5]),
                                ("face", 2.0, "bottom"), ("scale", 0.5, 0.5)]:  # fmt: skip
        slider = window.sliders[name]
        slider.GetRepresentation().SetValue(value)
        slider.InvokeEvent("InteractionEvent")
        assert getattr(window.look, name) == choice
        after = drawn(window)
        assert np.abs(after - before).max() > 50, name
        before = after
    for words, name in [("mesh", "show_mesh"), ("undeformed", "show_undeformed")]:
        button = window.buttons[words]
        button.GetRepresentation().SetState(0)
        button.InvokeEvent("StateChangedEvent")
        assert getattr(window.look, name) is False
    # Nothing is left of what was drawn before.
    assert len(window.plotter.scalar_bars) == 1
    window.step()
    assert window.look.phase == 270.0
    window.playing = True
    window.step()
    assert window.look.phase == 285.0
    window.plotter.close()


def test_view_without_a_screen_says_what_to_do(bent, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    with pytest.raises(sk.SkancfError, match=r"no screen .*write_html"):
        output.view(bent)
    with pytest.raises(sk.InputError, match="backend = 'web'"):
        bent.view(backend="web")


def test_view_opens_a_page_in_a_browser_and_in_a_notebook(bent, modes, monkeypatch):
    opened = []
    monkeypatch.setattr(viewer.webbrowser, "open", opened.append)
    page = modes.view(backend="page", field="u3")
    assert len(opened) == 1 and opened[0].startswith("file://")
    file = opened[0].removeprefix("file://")
    with open(file, encoding="utf-8") as stream:
        assert stream.read() == page.text
    os.unlink(file)
    monkeypatch.setattr(viewer, "in_notebook", lambda: True)
    shown = bent.view()._repr_html_()
    assert len(opened) == 1 and shown.startswith("<iframe srcdoc=") and "<script>" not in shown


# The page


def show_and_numbers(page):
    """What the page holds: its description, and its numbers."""
    described = json.loads(re.search(r'id="show">(.*?)</script>', page, re.DOTALL)[1])
    return described, zlib.decompress(base64.b64decode(re.search(r'id="numbers">(.*?)</script>', page, re.DOTALL)[1]))


def test_a_page_holds_the_states(motion):
    described, numbers = show_and_numbers(page_of(Show(motion, field="S11", title="A <strip>")))
    states = list(motion.states)
    n = states[0].system.geometry.n_elements
    assert described["names"] == [f"t = {t:.4g} s" for t in motion.times] and described["title"] == "A <strip>"
    field = next(each for each in described["fields"] if each["name"] == "S11")
    largest = 0.0
    for state, row in zip(states, described["states"], strict=True):
        sample = output.sample(state, 3)
        moved = np.frombuffer(numbers, "<f4", 48 * n, row["displacement"]).reshape(-1, 3)
        np.testing.assert_allclose(moved, sample.displacement, rtol=1e-6, atol=1e-12)
        at = np.frombuffer(numbers, "<f4", 48 * n, described["meshes"][row["mesh"]]["at"]).reshape(-1, 3)
        np.testing.assert_allclose(at + moved, sample.points, rtol=0, atol=1e-6)
        for face in ("top", "middle", "bottom"):
            low, high = field["stored"][face]
            stored = np.frombuffer(numbers, "<u2", 16 * n, row["values"][f"S11 {face}"])
            wanted = values(state, "S11", 3, face)
            np.testing.assert_allclose(low + (high - low) * stored / 65535, wanted, rtol=0, atol=(high - low) / 65535)
            largest = max(largest, np.abs(wanted).max())
    assert largest > 1e3  # the strip has fallen
    rim = described["meshes"][0]
    assert rim["sides"] == 2 * (3 + 2) and described["fields"][0]["name"] == "displacement"


def test_a_page_needs_no_network(modes, tmp_path):
    file = output.write_html(modes, tmp_path / "modes.html", fields=["displacement", "M11"], title="</script><b>")
    page = file.read_text()
    assert file.stat().st_size < 700_000
    assert not re.findall(r'(?:src|href)="(?!data:)', page) and "<b>" not in page.replace("three.js", "")
    assert page.count("</script>") == 4
    for options, message in [({"fields": ["S31"]}, "field = 'S31'"), ({"fields": "mises"}, "fields = 'mises'"),
                             ({"seconds_per_frame": 0}, "seconds_per_frame"), ({"scale": "big"}, "scale")]:  # fmt: skip
        with pytest.raises(sk.InputError, match=message):
            output.write_html(modes, tmp_path / "modes.html", **options)


CHROME = shutil.which("chromium"), shutil.which("chromedriver")
SWITCHES = ("--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
            "--disable-component-update", "--disable-sync", "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader")  # fmt: skip


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    webdriver = pytest.importorskip("selenium.webdriver", reason="needs selenium, an extra for development")
    from selenium.webdriver.chrome.service import Service

    if not all(CHROME):
        pytest.skip("needs Debian's chromium and chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = CHROME[0]
    for switch in (*SWITCHES, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(switch)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(service=Service(CHROME[1]), options=options)
    yield driver
    driver.quit()


def test_a_browser_draws_the_page(browser, modes, motion, tmp_path):
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.support.ui import WebDriverWait

    def run(script):
        return browser.execute_script(script)

    def put(name, value):
        run(f"const e = document.getElementById('{name}'); e.value = '{value}'; e.dispatchEvent(new Event('input'))")

    def shot():
        from io import BytesIO

        from PIL import Image

        run("page.renderer.render(page.scene, page.camera)")
        return np.asarray(Image.open(BytesIO(browser.get_screenshot_as_png())).convert("RGB")).astype(float)

    for width, states in [(1400, modes), (400, motion)]:
        size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": width < 600}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        browser.get(output.write_html(states, tmp_path / f"{width}.html", field="u3").as_uri())
        WebDriverWait(browser, 20).until(lambda _: run("return document.documentElement.dataset.ready"))
        assert run("return document.documentElement.scrollWidth") <= width
        # The surface that is drawn is the state, at every vertex and after the slider has moved.
        put("state", 1)
        state = reel_of(states).states[1]
        k = run("return page.bodies[0].k")
        seen = np.array(run("return Array.from(page.bodies[0].position.array)")).reshape(-1, 3)
        np.testing.assert_allclose(seen, output.sample(state, k).points, rtol=0, atol=1e-6)
        normals = np.array(run("return Array.from(page.bodies[0].normal.array)")).reshape(-1, 3)
        upper = output.sampling.sample_surface(state, k, 0.005).points - seen
        np.testing.assert_allclose(np.abs((normals * upper).sum(axis=1)), 0.005, rtol=1e-4)
        # It turns under the pointer, and a field at a face is another picture.
        before = shot()
        canvas = browser.find_element(By.ID, "canvas")
        ActionChains(browser).move_to_element(canvas).click_and_hold().move_by_offset(40, -30).release().perform()
        place = run("""const p = page.bodies[0].position, k = Math.floor(p.count / 2);
            const v = new THREE.Vector3(p.getX(k), p.getY(k), p.getZ(k)).project(page.camera);
            return [v.x * page.canvas.clientWidth / 2, -v.y * page.canvas.clientHeight / 2].map(Math.round)""")
        ActionChains(browser).move_to_element_with_offset(canvas, *place).perform()
        assert re.match(r"u3 = \S+ m$", browser.find_element(By.ID, "readout").text)
        turned = shot()
        put("field", "S11")
        put("face", "bottom")
        assert np.abs(turned - before).max() > 100 and np.abs(shot() - turned).max() > 100
        assert "stress S11, bottom face" in canvas.get_attribute("aria-label")
        assert browser.get_log("browser") == []


# Films


def test_a_film_for_browsers_and_slides(modes, tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="needs the extra 'view'")
    path = output.animation(modes.swing(1, frames=6), tmp_path / "film.mp4", size=(201, 150), seconds_per_frame=0.1)
    frames, seconds = ffmpeg.count_frames_and_secs(str(path))
    described = next(reader := ffmpeg.read_frames(str(path)))
    reader.close()
    assert frames == 6 and seconds == pytest.approx(0.6, abs=0.02)
    assert described["size"] == (202, 150) and described["codec"] == "h264" and "yuv420p" in described["pix_fmt"]
    assert [file.name for file in tmp_path.iterdir()] == ["film.mp4"]


def test_films_draw_one_picture_at_a_time(modes, tmp_path, monkeypatch):
    counted = []

    def save(images, part, seconds):
        next(images)
        counted.append(len(drawn))
        images.close()
        part.write_bytes(b"")

    drawn = []
    monkeypatch.setattr(films, "draw", lambda *given, draw=films.draw: drawn.append(1) or draw(*given))
    monkeypatch.setattr(films, "_save_gif", save)
    output.animation((state for state in modes.swing(0, frames=5)), tmp_path / "a.gif", size=(100, 80))
    assert counted == [1]


def test_a_film_without_its_package_says_what_to_install(modes, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(sk.SkancfError, match=r"pip install 'skancf\[view\]'"):
        output.animation(modes.swing(0, frames=2), tmp_path / "film.mp4", size=(100, 80))
    assert not list(tmp_path.iterdir())


# Curved cells


@pytest.mark.parametrize("theory", ["full", "kirchhoff"])
def test_curved_cells_are_the_elements(tmp_path, theory):
    import pyvista
    from vtkmodules.vtkCommonCore import reference

    plate = sk.Problem(sk.AnnulusSector(1.0, 2.0), 0.01, sk.Isotropic(1e9, 0.3, 1e3))
    tree = sk.meshes.quadtree(sk.meshes.uniform(plate.surface, 2, 2), plate.surface)
    system = plate.on(tree.refined([0]), theory)
    rng = np.random.default_rng(2)
    state = sk.Solution(system, system.undeformed + 0.05 * rng.normal(size=system.n_dofs), time=0.5)
    files = output.write([state], tmp_path / "run.pvd", cells="curved"), output.write(state, tmp_path / "flat.vtu")
    [(time, file)] = output.read(files[0])
    cells = pyvista.read(file)
    assert time == 0.5 and set(cells.celltypes) == {pyvista.CellType.LAGRANGE_QUADRILATERAL}
    assert cells.n_cells == system.geometry.n_elements and file.stat().st_size < 0.8 * files[1].stat().st_size
    np.testing.assert_array_equal(cells.cell_data["element"], np.arange(cells.n_cells))
    flat = pyvista.read(files[1])
    corner = np.linalg.norm(cells.GetCell(0).GetBounds())
    assert corner > 0 and set(cells.point_data) == set(flat.point_data)
    for element in range(cells.n_cells):
        for local in rng.random((3, 2)):
            place, weights = [0.0, 0.0, 0.0], [0.0] * 16
            cells.GetCell(element).EvaluateLocation(reference(0), [*local, 0.0], place, weights)
            at = system.geometry.parameters(local[:, None])[:, element, 0]
            np.testing.assert_allclose(place, state.position(at), rtol=0, atol=1e-12)
            numbers = [cells.GetCell(element).GetPointId(k) for k in range(16)]
            moved = np.array(weights) @ cells.point_data["displacement"][numbers]
            np.testing.assert_allclose(moved, state.displacement(at), rtol=0, atol=1e-12)
    # Fields are those at the 16 points.
    read = output.read(file)
    assert read.cells[0].type == "VTK_LAGRANGE_QUADRILATERAL"
    np.testing.assert_array_equal(read.point_data["mises_top"], values(state, "mises", 3, "top"))


def test_curved_cells_are_not_subdivided(bent, tmp_path):
    with pytest.raises(sk.InputError, match="subdivisions = 2: curved cells"):
        output.write(bent, tmp_path / "a.vtu", cells="curved", subdivisions=2)
    with pytest.raises(sk.InputError, match="cells = 'bezier': choose one of 'flat' or 'curved'"):
        output.write(bent, tmp_path / "a.vtu", cells="bezier")
