import re
import socket

import pytest
from pydrake.geometry import Rgba, Sphere

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.meshcat_scene import set_scene_camera, start_meshcat, write_scene_html


@pytest.fixture(scope="module")
def meshcat():
    return start_meshcat(port=0)


def test_listens_on_this_machine_alone(meshcat):
    assert meshcat.web_url().startswith("http://localhost:")
    with socket.create_connection(("127.0.0.1", meshcat.port()), timeout=5):
        pass
    found = socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)
    for address in {address for *_, (address, _) in found if not address.startswith("127.")}:
        with pytest.raises(OSError):
            socket.create_connection((address, meshcat.port()), timeout=5)


def test_a_taken_port_is_refused_with_its_number(meshcat):
    with pytest.raises(BlfDmpError, match=rf"^Meshcat: port {meshcat.port()} is taken on localhost; [^\n]*$"):
        start_meshcat(port=meshcat.port())


@pytest.mark.parametrize("port", [-1, 80, 65536])
def test_a_port_out_of_range_is_refused(port):
    with pytest.raises(BlfDmpError, match=f"port {port} is out of range"):
        start_meshcat(port=port)


@pytest.mark.parametrize("host", ["no.such.host.invalid", "x" * 300])
def test_an_unknown_host_is_refused_and_does_not_end_the_process(host):
    with pytest.raises(BlfDmpError, match="is unknown; use localhost"):
        start_meshcat(host=host, port=0)


def test_a_camera_on_its_target_is_refused(meshcat):
    set_scene_camera(meshcat)
    with pytest.raises(BlfDmpError, match="move one of them"):
        set_scene_camera(meshcat, (1.0, 2.0, 3.0), (1.0, 2.0, 3.0))


def test_page_has_title_and_legend_escaped_and_stands_alone(meshcat, tmp_path):
    meshcat.SetObject("/ball", Sphere(0.1), Rgba(1, 0, 0, 1))
    page = write_scene_html(meshcat, tmp_path / "new" / "run.html", title="A < B & C", legend={"safe": "#009E73"})
    text = page.read_text(encoding="utf-8")
    assert "<title>A &lt; B &amp; C</title>" in text
    assert text.count('id="caption"') == 1
    assert "background:#009E73" in text and "safe</div>" in text
    assert text.rstrip().endswith("</html>")
    assert not re.findall(r"<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)\s*=", text), "fetches something"
    assert page.stat().st_size < 5e6


def test_a_page_that_cannot_be_written_is_refused(meshcat, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(BlfDmpError, match="cannot be written"):
        write_scene_html(meshcat, tmp_path / "file" / "run.html")
    with pytest.raises(BlfDmpError, match="cannot be written"):
        write_scene_html(meshcat, tmp_path)
