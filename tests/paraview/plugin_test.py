#!/usr/bin/env python3
"""The plugin in pvbatch, used as a user would. Usage: see paraview_case.py."""
import unittest

from paraview_case import DATA, ParaViewCase, command

# What each script may use: the state of the filter as text, and whether two grids are the same to the bit.
TOOLS = """
def code(proxy):
    proxy.UpdatePipeline()
    proxy.UpdatePropertyInformation()
    return proxy.GetProperty("ErrorCode")[0]

def numbers(proxy):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    grid = servermanager.Fetch(proxy)
    out = [vtk_to_numpy(grid.GetPoints().GetData()), vtk_to_numpy(grid.GetCells().GetConnectivityArray())]
    for data in grid.GetPointData(), grid.GetCellData():
        for i in range(data.GetNumberOfArrays()):
            out.append(vtk_to_numpy(data.GetArray(i)))
    return out

def same(one, other):
    return [a.tobytes() for a in numbers(one)] == [b.tobytes() for b in numbers(other)]

def cells(proxy):
    return proxy.GetDataInformation().GetNumberOfCells()
"""


class Plugin(ParaViewCase):
    def script(self, text, **how):
        return self.run_script(TOOLS + f"mesh = XMLUnstructuredGridReader(FileName=[{str(self.mesh)!r}])\n" + text, **how)

    def test_makes_the_commands_mesh(self):
        expected = self.folder / "expected.vtu"
        for options, settings in ((["--reduction", "80%"], "TargetReduction=0.8"),
                                  (["--reduction", "60%", "--boundary", "planar", "--array", "front", "--regions", "none"],
                                   "TargetReduction=0.6, BoundaryMode='Planar', SteeringPointArrays=['front'], KeepRegions=0"),
                                  (["--boundary", "0.5%", "--max-error", "2%", "--roi", "box=0,1,0,1,0,0.3", "--regions", "region"],
                                   "BoundaryMode='Within Tolerance', BoundaryTolerance=0.005, MaximumError=0.02,"
                                   "RegionsOfInterest=['box=0,1,0,1,0,0.3'], RegionArrays=['region']"),
                                  (["--reduction", "90%", "--boundary", "2%", "--feature-angle", "120"],
                                   "TargetReduction=0.9, BoundaryMode='Within Tolerance', BoundaryTolerance=0.02, FeatureAngle=120"),
                                  (["--reduction", "60%", "--weight", "front"], "TargetReduction=0.6, WeightArrayName='front'"),
                                  (["--reduction", "30%", "--method", "tetfuse"], "TargetReduction=0.3, Method='TetFuse'")):
            with self.subTest(settings=settings):
                command("simplify", self.mesh, "-o", expected, "--encoding", "inline", "--quiet", *options)
                out = self.script(f"""
result = TetFusion(Input=mesh, {settings})
assert code(result) == 0
assert 0 < cells(result) < cells(mesh)
assert same(result, XMLUnstructuredGridReader(FileName=[{str(expected)!r}]))
names = lambda p: ([a.Name for a in p.PointData], [a.Name for a in p.CellData])
assert names(result) == names(mesh), names(result)
print("stopped:", result.GetProperty("StopSentence")[0])
""")
                self.assertIn("stopped: ", out)

    def test_blunt_fin(self):
        path = DATA / "bluntfin.vtu"
        if not path.exists():
            self.skipTest(f"{path} is not there")
        mesh, expected = self.folder / "fin.vtu", self.folder / "smaller_fin.vtu"
        command("convert", path, mesh, "--encoding", "inline", "--quiet")
        command("simplify", path, "-o", expected, "--reduction", "50%", "--encoding", "inline", "--quiet")
        self.script(f"""
fin = XMLUnstructuredGridReader(FileName=[{str(mesh)!r}])
result = TetFusion(Input=fin, TargetReduction=0.5)
assert code(result) == 0 and cells(result) < cells(fin) == 187395
assert same(result, XMLUnstructuredGridReader(FileName=[{str(expected)!r}]))
""")

    def test_a_weight_keeps_the_mesh_finer(self):
        late = self.folder / "late.vtu"  # where the front has come to the middle
        command("generate", "five", "--tets", self.TETS, "--jitter", "0.5", "--time", "8", "--quiet", "-o", self.folder / "raw_late.vtu")
        command("convert", self.folder / "raw_late.vtu", late, "--encoding", "inline", "--quiet")
        self.script(f"mesh.FileName = [{str(late)!r}]" + """
def heavy(proxy):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    return (vtk_to_numpy(servermanager.Fetch(proxy).GetPointData().GetArray("front")) >= 0.5).sum()
result = TetFusion(Input=mesh, TargetReduction=0.6, KeepRegions=0, BoundaryMode="Within Tolerance", BoundaryTolerance=0.005)
assert result.WeightArrayName == ""
assert code(result) == 0
before, tets = heavy(result), cells(result)
result.WeightArrayName = "front"
assert code(result) == 0 and abs(cells(result) - tets) < 100
assert heavy(result) > 1.2 * before, (heavy(result), before)
result.WeightArrayName = "nothing"
assert code(result) == 40002
result.WeightArrayName = ""
assert code(result) == 0 and heavy(result) == before
""")

    def test_defaults_steer_by_the_active_scalars(self):
        self.script("""
result = TetFusion(Input=mesh)
assert (result.TargetReduction, result.MaximumError, result.BoundaryMode) == (0, 0, "Exact")
assert len(result.SteeringPointArrays) + len(result.SteeringCellArrays) + len(result.RegionArrays) == 0
assert code(result) == 0
import json
report = json.loads(result.GetProperty("Report")[0])
assert report["output"]["boundary_triangles"] == report["input"]["boundary_triangles"]
assert abs(report["output"]["volume"] - report["input"]["volume"]) < 1e-5
assert same(result, TetFusion(Input=mesh, MaximumError=0.01, SteeringPointArrays=["temperature"]))
assert "OriginalPointIds" not in result.PointData.keys()
result.OriginalIds = 1
assert code(result) == 0 and result.PointData["OriginalPointIds"].GetRange()[0] == -1
result.SteeringCellArrays = ["region"]
result.SteeringPointArrays = ["front"]
result.SteeringPointArrays = ["velocity"]
assert code(result) == 0
assert json.loads(result.GetProperty("Report")[0])["steering"] == ["cell:region", "velocity"], result.GetProperty("Report")[0]
""")

    def test_a_state_brings_the_filter_back(self):
        state = str(self.folder / "state.pvsm")
        self.script(f"""
result = TetFusion(registrationName="Smaller", Input=mesh, TargetReduction=0.7, SteeringPointArrays=["front"], BoundaryMode="Planar")
assert code(result) == 0
number = cells(result)
SaveState({state!r})
ResetSession()
LoadState({state!r})
result = FindSource("Smaller")
assert (result.TargetReduction, list(result.SteeringPointArrays), result.BoundaryMode) == (0.7, ["front"], "Planar")
assert code(result) == 0 and cells(result) == number
""")

    def test_progress_never_falls(self):
        self.script("""
result = TetFusion(Input=mesh, TargetReduction=0.8, ChunkTets=2000)
shares = []
result.GetClientSideObject().AddObserver("ProgressEvent", lambda caller, event: shares.append(caller.GetProgress()))
assert code(result) == 0
assert shares == sorted(shares) and shares[-1] == 1 and len(set(shares)) > 5, shares
""")

    def test_an_error_is_seen_but_does_not_end_pvbatch(self):
        bad = "result = TetFusion(Input=mesh, TargetReduction=0.5, SteeringPointArrays=['nothing'])\nresult.UpdatePipeline()\n"
        self.assertIn('no array "nothing" to steer by; point arrays: temperature', self.script(bad))
        self.script(bad + "import sys; sys.exit(code(result) - 40000)", code=2)
        self.script("""
result = TetFusion(Input=mesh, TargetReduction=1)
assert code(result) == 40002 and cells(result) == 0
result.TargetReduction = 0.5
assert code(result) == 0 and cells(result) > 0
result.TargetReduction = 0.999
result.Strict = 1
assert code(result) == 40006 and cells(result) > 0
""")

    def test_is_in_its_menu_and_says_what_its_properties_are(self):
        self.script("""
LoadPlugin(%r, remote=False, ns=globals())
result = TetFusion(Input=mesh)
hints = result.SMProxy.GetHints().FindNestedElementByName("ShowInMenu")
assert hints.GetAttribute("category") == "TetFusion"
for name in result.ListProperties():
    described = result.GetProperty(name).SMProperty.GetDocumentation()
    assert described is not None and described.GetDescription().strip(), name
""" % str(self.plugin / "TetFusion.so"), load=False)

    def test_pythons_function_works_in_pvbatch(self):
        self.script(f"""
import sys
sys.path.insert(0, {str(self.plugin / "python")!r})
import vtktetfusion
smaller = vtktetfusion.simplify(servermanager.Fetch(mesh), reduction=0.5)
result = TetFusion(Input=mesh, TargetReduction=0.5)
assert code(result) == 0 and smaller.GetNumberOfCells() == cells(result)
""")


if __name__ == "__main__":
    unittest.main()
