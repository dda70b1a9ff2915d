"""`mobius info`."""

import json

import trimesh

from tests.shapes import torus


def test_a_table_for_each_mesh(mobius, pair):
    ended = mobius("info", *pair[:2])
    assert (ended.code, ended.err) == (0, "")
    for words in ("one.off", "two.off", "642", "1280", "genus", "repairs"):
        assert words in ended.out
    assert "\x1b" not in ended.out


def test_json_is_a_list_with_an_entry_for_each_file(mobius, pair, klein, broken):
    ended = mobius("info", pair[0], klein, broken, "--json")
    assert ended.code == 5
    good, one_sided, unreadable = json.loads(ended.out)
    assert (good["path"], good["vertices"], good["faces"]) == (str(pair[0]), 642, 1280)
    assert (good["usable"], good["reason"], good["genus"]) == (True, None, 0)
    assert (one_sided["usable"], one_sided["genus"]) == (False, None)
    assert "one side" in one_sided["reason"]
    assert unreadable["usable"] is False
    assert str(broken) in unreadable["reason"]
    assert set(unreadable) <= set(good)


def test_one_message_for_each_bad_file(mobius, pair, klein, broken):
    some = mobius("info", pair[0], klein, broken)
    assert some.code == 5
    lines = some.err.strip().split("\n")
    assert len(lines) == 2
    assert lines[0].startswith("error: klein.off")
    assert str(broken) in lines[1]
    assert "not usable because" in some.out
    assert mobius("info", klein, broken).code == 3
    assert mobius("info", broken).code == 3
    assert mobius("info", "no-such-file.off").code == 3


def test_odd_names_are_shown_as_they_are(mobius, pair, tmp_path):
    path = tmp_path / "[red]:smile: Möbius.off"
    path.write_bytes(pair[0].read_bytes())
    ended = mobius("info", path)
    assert ended.code == 0
    assert "[red]:smile: Möbius.off" in ended.out


def test_a_name_that_is_not_text(start_mobius, pair, tmp_path):
    path = tmp_path / b"\xff.off".decode("utf-8", "surrogateescape")
    path.write_bytes(pair[0].read_bytes())
    process = start_mobius("info", path)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, "")
    assert "642" in out


def test_handles_are_listed(mobius, tmp_path):
    vertices, faces = torus(around=16, across=8)
    path = tmp_path / "ring.off"
    path.write_bytes(trimesh.Trimesh(vertices, faces, process=False).export(file_type="off").encode())
    ended = mobius("info", path)
    assert ended.code == 0
    (line,) = [line for line in ended.out.splitlines() if "handle places" in line]
    assert "length 6.1229)" in line
    (entry,) = json.loads(mobius("info", path, "--json").out)
    assert entry["usable"] and entry["genus"] == 1
    (handle,) = entry["handle_places"]
    assert f" {handle['vertices'][0]} (" in line
