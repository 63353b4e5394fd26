"""Every field of scene.proto can be set and read in Python, and reaches the file."""
import os
import subprocess

import pytest

import scene_schema
import tessera as ts
from tessera import _value

MESSAGES, ENUMS = scene_schema.read()
# Arrays in Python, which `test_arrays` is about; vectors and colours, which are sequences.
ARRAYS = {"Blob", "BlobRef"}
PLAIN = {"Vec2": (1.5, 2.5), "Vec3": (1.5, 2.5, 3.5), "Color": (.25, .5, .75)}
UNIONS = ("Shape", "Light", "Material", "Texture")
KINDS = {field.type: (union, field.name) for union in UNIONS for field in MESSAGES[union] if field.oneof}


def class_of(message):
    union, kind = KINDS.get(message, (message, ""))
    return _value.CLASSES[f"tessera.v1.{union}", kind]


def sample(field):
    """A value that is not the default, and how text has it."""
    if field.type in ENUMS:
        name = ENUMS[field.type][-1]
        return name.lower().removeprefix(field.type.split(".")[-1].lower() + "_").replace("_", "-"), name
    return {"double": (.375, "0.375"), "float": (.375, "0.375"), "bool": (True, "true"),
            "string": ("word", '"word"'), "uint32": (3, "3"), "int32": (3, "3")}[field.type]


def is_leaf(field):
    return field.type in ENUMS or field.type in ("double", "float", "bool", "string", "uint32", "int32")


def paths():
    """The shortest way of fields from the scene to each message."""
    found, todo = {"Scene": []}, ["Scene"]
    while todo:
        message = todo.pop(0)
        for field in MESSAGES[message]:
            if field.type in MESSAGES and field.type not in found:
                found[field.type] = [*found[message], field]
                todo.append(field.type)
    return found


PATHS = paths()


def wrap(value, path):
    """The scene that holds `value` at the end of a path."""
    for field in reversed(path):
        if field.type in PLAIN or class_of(field.message) is not type(value) or not field.oneof:
            made = class_of(field.message)
            if not (field.oneof and field.message in UNIONS):  # a kind is the union's value itself
                value = made(**{field.name: [value] if field.repeated else value})
    return value


def converted(scene, folder):
    scene.save(folder / "scene.tesserab")
    subprocess.run([os.environ["TESSERA_PROGRAM"], "convert", folder / "scene.tesserab",
                    folder / "scene.tessera"], check=True, capture_output=True)
    return (folder / "scene.tessera").read_text()


def leaves_of(message):
    """Its fields that hold no messages. A file that is included or a picture's would have to be there."""
    return [field for field in MESSAGES[message]
            if is_leaf(field) and field.name != "file" and field.message != "Include"]


@pytest.mark.parametrize("message", [m for m in sorted(set(MESSAGES) - ARRAYS - set(PLAIN)) if leaves_of(m)])
def test_each_leaf_field_reaches_the_text(message, tmp_path):
    leaves = leaves_of(message)
    values = {field.name: [sample(field)[0]] if field.repeated else sample(field)[0] for field in leaves}
    value = class_of(message)(**values)
    for name, given in values.items():
        assert getattr(value, name) == given
    scene = wrap(value, PATHS[message])
    text = converted(scene, tmp_path)
    for field in leaves:
        assert f"{field.name}: {sample(field)[1]}" in text or f"{field.name}: [{sample(field)[1]}]" in text
    assert ts.load(tmp_path / "scene.tessera") == scene


@pytest.mark.parametrize("message", sorted(set(MESSAGES) - ARRAYS - set(PLAIN)))
def test_each_message_has_a_class_with_all_its_fields(message):
    made = class_of(message)
    kinds = {field.name for field in MESSAGES[message] if field.oneof and message in UNIONS}
    for field in MESSAGES[message]:
        if field.type != "Blob" and field.name not in kinds:
            assert field.name in made._FIELDS, field
    assert made.__doc__ and getattr(ts, made.__name__) is made and made.__name__ in ts.__all__


def test_vectors_and_colours_reach_the_text(tmp_path):
    scene = ts.Scene(background="#bcb", nodes=[ts.Sphere((1.5, 2.5, 3.5))])
    text = converted(scene, tmp_path)
    assert all(part in text for part in ("x: 1.5", "y: 2.5", "z: 3.5", "solid"))
    again = ts.load(tmp_path / "scene.tessera")
    again.metadata = None
    assert again == scene


def test_a_field_without_python_is_found():
    assert "a_field_to_come" not in class_of("Sphere")._FIELDS
    with pytest.raises(TypeError, match="no keyword 'raduis'; did you mean 'radius'"):
        ts.Sphere(raduis=1)
