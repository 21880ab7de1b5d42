import json

from unstructured_mg.playback.pictures import Column, Picture, Seam, TransitionPictures, read_pictures

PICTURES = TransitionPictures(
    "take:12",
    "take:80",
    (Column("source", "take:2"), Column("step", "-3"), Column("target", "take:90")),
    Picture(b"sheet", 30, 10),
    Seam(Picture(b"start", 40, 11), ("a", "b", "c", "d"), 1.5, 2.25),
    Seam(Picture(b"end", 41, 12), ("e", "f", "g", "h"), 0.5, 0.125),
    Picture(b"film", 90, 13),
    25,
    (3, 21),
    30.0,
)


def test_files_are_read_back_as_they_were(tmp_path):
    files = PICTURES.files()
    assert sorted(files) == ["end.jpg", "film.jpg", "pictures.json", "sheet.jpg", "start.jpg"]
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    assert read_pictures(tmp_path) == PICTURES
    assert json.loads(files["pictures.json"])["seams"]["start"]["own_change"] == 2.25
