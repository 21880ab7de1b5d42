import pytest

from unstructured_mg.capture.mtl import read_mtl


@pytest.mark.parametrize(
    "line, name",
    [
        ("map_Kd a.png", "a.png"),
        ("map_Kd   my skin 01.png  ", "my skin 01.png"),
        ('map_Kd "quoted name.png"', "quoted name.png"),
        ("\tmap_kd tab.png", "tab.png"),
        ("map_Kd\ttab after.png", "tab after.png"),
        ("map_Kd -blendu on -clamp off -mm 0 1 a b.png", "a b.png"),
        ("map_Kd -s 1 1 1 -o 0.5 skin.png", "skin.png"),
        ("map_Kd -s 2 skin.png", "skin.png"),
        ("map_Kd -o 1 2 3 4.png", "4.png"),
        ("map_Kd -texres 512 -bm 0.3 -imfchan r -type sphere -boost 2 -cc on x.png", "x.png"),
        ("map_Kd -my odd name.png", "-my odd name.png"),
        ("map_Ka fallback.png", "fallback.png"),
        ("map_Ka fallback.png\nmap_Kd used.png", "used.png"),
        ("map_Kd first.png\nmap_Kd second.png", "first.png"),
    ],
)
def test_file_name_of_a_texture_statement(line, name):
    assert read_mtl(f"# made by hand\nnewmtl skin\nKd 1 1 1\n{line}\nillum 2\n") == {"skin": name}


def test_materials_without_an_image_are_left_out():
    text = "newmtl with space \nmap_Kd a.png\nnewmtl plain\nKd 1 0 0\nmap_Bump b.png\nnewmtl empty\nmap_Kd -s 1\n"
    assert read_mtl(text.replace("\n", "\r\n")) == read_mtl(text)
    assert read_mtl(text) == {"with space": "a.png"}
