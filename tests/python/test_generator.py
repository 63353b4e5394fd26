"""The classes are made of fields that the module can read and write; others end the build."""
import os
import pathlib
import subprocess

import pytest

GENERATOR = pathlib.Path(os.environ["TESSERA_PROGRAM"]).parent / "generate_messages"


def generate(tmp_path, field, comment="What it is; default 3."):
    (tmp_path / "scene.proto").write_text(f"""
        syntax = "proto3"; package tessera.v1; enum Kind {{ NONE = 0; }}
        message Metadata {{
          map<string, string> properties = 1;  // texts
        }}
        message BlobRef {{ string digest = 1; uint64 size = 2; }}
        message FloatInput {{
          double value = 1;  // a factor
        }}
        message Scene {{
          Metadata metadata = 1;  // who made it
          message Inside {{
            {field} = 1;  // {comment}
          }}
          Inside inside = 2;  // what is in it
        }}""")
    subprocess.run(["protoc", "--proto_path=.", "--include_source_info", "--descriptor_set_out=scene.descriptors",
                    "scene.proto"], check=True, cwd=tmp_path)
    return subprocess.run([GENERATOR, "scene.descriptors", "made.py"], capture_output=True, text=True, cwd=tmp_path)


@pytest.mark.parametrize("field, found", [
    ("int64 much", "a number of 64 bits"), ("uint64 much", "a number of 64 bits"), ("bytes much", "bytes"),
    ("map<string, string> much", "a second map"), ("repeated bool much", "many of type bool"),
    ("repeated int32 much", "many of type int32"), ("repeated Kind much", "many of type enum")])
def test_a_field_that_values_cannot_have_ends_the_build(tmp_path, field, found):
    done = generate(tmp_path, field)
    assert done.returncode == 1 and not (tmp_path / "made.py").exists()
    assert done.stderr == f"tessera.v1.Scene.Inside.much: {found}; expected what values of Python are made of\n"


@pytest.mark.parametrize("field", ["repeated double much", "repeated uint32 much", "repeated string much",
                                   "repeated Metadata much", "optional bool much", "Kind much", "BlobRef much"])
def test_other_fields_become_attributes(tmp_path, field):
    assert generate(tmp_path, field).returncode == 0 and "    much: " in (tmp_path / "made.py").read_text()


@pytest.mark.parametrize("field, comment, missing", [
    ("double much", "", "no comment; expected what it is, with unit and range"),
    ("Metadata much", "", "no comment; expected what it is, with unit and range"),
    ("optional double much", "metres, > 0", "no default in its comment; expected one"),
    ("optional string much", "a name", "no default in its comment; expected one"),
    ("FloatInput much", "0 to 1", "no default in its comment; expected one")])
def test_a_field_that_help_would_not_explain_ends_the_build(tmp_path, field, comment, missing):
    done = generate(tmp_path, field, comment)
    assert done.returncode == 1 and not (tmp_path / "made.py").exists()
    assert done.stderr == f"tessera.v1.Scene.Inside.much: {missing}\n"


@pytest.mark.parametrize("field, comment, words", [
    ("double much", "metres", "metres; default 0"), ("bool much", "it is much", "it is much; default False"),
    ("string much", "A name.", "A name; default none"), ("repeated double much", "seconds", "seconds; default none"),
    ("Metadata much", "more", "more; default none"), ("optional double much", "default 3", "default 3"),
    ("double much", "pixels; 0: no bound", "pixels; 0: no bound")])
def test_the_default_is_told(tmp_path, field, comment, words):
    assert generate(tmp_path, field, comment).returncode == 0
    assert f"        much: {words}\n" in (tmp_path / "made.py").read_text()
