#!/usr/bin/env python3
"""check_tree.py must find each kind of violation in a small tree made for it, and nothing in a good one."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

CHECK = pathlib.Path(__file__).with_name("check_tree.py")
GOOD = {
    "calot/base/ids.h": "#pragma once\n",
    "calot/mesh/mesh.h": '#include "calot/base/ids.h"\n',
    "calot/fem/model.h": '#include "calot/mesh/mesh.h"\n// Source: [Cotin1999]\n',
    "calot/patient/scan.h": "#include <calot/mesh/mesh.h>\n",
    "app/main.cpp": '#include "calot/fem/model.h"\n#include "app/terminal.h"\n',
    "docs/architecture.md": "| `base/` | x |\n| `mesh/` | x |\n| `fem/` | x |\n| `patient/` | x |\n[math](math.md)\n",
    "docs/math.md": "See /usr/include and [Cotin1999].\n",
    "docs/references.bib": "@article{Cotin1999,\n}\n",
}


def problems(**changes):
    with tempfile.TemporaryDirectory() as folder:
        for name, text in {**GOOD, **changes}.items():
            path = pathlib.Path(folder) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        run = subprocess.run([sys.executable, str(CHECK), folder], capture_output=True, text=True)
        assert (run.returncode != 0) == bool(run.stdout), run
        return run.stdout


class CheckTree(unittest.TestCase):
    def test_a_good_tree_passes(self):
        self.assertEqual(problems(), "")

    def test_an_earlier_room_may_not_include_a_later_one(self):
        found = problems(**{"calot/mesh/mesh.h": '// x\n#include "calot/fem/model.h"\n'})
        self.assertEqual(found, "calot/mesh/mesh.h:2: mesh may not include fem\n")

    def test_patient_stands_on_base_and_mesh_only(self):
        self.assertIn("patient may not include fem", problems(**{"calot/patient/scan.h": '#include "calot/fem/model.h"\n'}))

    def test_nothing_in_calot_includes_app_or_bench(self):
        for folder in ("app", "bench", "tests"):
            found = problems(**{"calot/fem/model.h": f'#include "{folder}/x.h"\n'})
            self.assertIn(f"nothing in calot/ includes {folder}/", found)

    def test_every_room_is_described(self):
        self.assertIn("says nothing of calot/cut/", problems(**{"calot/cut/cut.h": "\n"}))

    def test_no_room_is_made_up(self):
        page = GOOD["docs/architecture.md"] + "| `cut/` | x |\n"
        self.assertIn("describes calot/cut/", problems(**{"docs/architecture.md": page}))

    def test_an_unknown_room_is_named(self):
        page = GOOD["docs/architecture.md"] + "| `attic/` | x |\n"
        found = problems(**{"calot/attic/a.h": '#include "calot/base/ids.h"\n', "docs/architecture.md": page})
        self.assertIn("calot/attic is not a room", found)

    def test_machine_paths_are_found(self):
        for place in ("/home" + "/ann/calot", "/root" + "/x", "/work" + "/main"):
            self.assertIn("names a place on one machine", problems(**{"docs/math.md": f"Look in {place}.\n"}))

    def test_broken_links_and_unknown_citations_are_found(self):
        self.assertIn("links to gone.md", problems(**{"docs/math.md": "[x](gone.md)\n"}))
        self.assertIn("cites [" + "Nobody1900]", problems(**{"docs/math.md": "[" + "Nobody1900]\n"}))


unittest.main()
