"""Simplifies a mesh on several processes, with ParaView's own engines.

    mpirun -n 4 pvbatch distributed.py in.pvtu -o out.pvtu --reduction 80%

Each process (rank) takes a part, with a layer of ghost cells round it, and simplifies it; the points that ghost cells have, too, stay
where they are, so that the parts fit at every moment. Then the mesh is cut elsewhere, and a second pass frees what the first one had to
leave at its cuts; not with --max-error, since only a single pass can keep that. The result does not depend on the order of events, but
on the number of processes. Read are .vtu and .pvtu, written a .pvtu and the folder of its pieces, with the global ids that join them.
distributed.py --help lists the options.

An error on one rank is printed and ends all, with the exit code that the command tetfusion would have.
"""
import pathlib
import sys
import traceback

HERE = pathlib.Path(__file__).resolve().parent  # pvbatch looks for modules there, too


def run(arguments):
    """On all ranks at once."""
    from tetfusion_ranks.failure import IO, Failure
    from tetfusion_ranks.ranks import Ranks
    ranks = Ranks()
    try:
        from tetfusion_ranks.command_line import parse
        from tetfusion_ranks.job import work  # in here, so that what is missing on one rank ends all of them
        work(parse(arguments), ranks)
    except Failure as failure:
        ranks.end(failure.code, failure, failure.of_all)
    except Exception as error:
        is_ours = hasattr(error, "code")
        ranks.end(error.code if is_ours else IO, error if is_ours else traceback.format_exc(), False)


def main():
    """Started with --sym all ranks come here, else the first one, which sends the others to run()."""
    from paraview import simple  # before all else: ends the other ranks when this one ends
    from paraview.modules.vtkRemotingCore import vtkProcessModule
    from tetfusion_ranks.command_line import parse
    parse(sys.argv[1:])
    process = vtkProcessModule.GetProcessModule()
    if process.GetNumberOfLocalPartitions() == 1 or process.GetSymmetricMPIMode():
        run(sys.argv[1:])
        return
    source = simple.ProgrammableSource(
        Script=f"import sys\nsys.path.insert(0, {str(HERE)!r})\nimport distributed\ndistributed.run({sys.argv[1:]!r})\n")
    source.UpdatePipeline()


if __name__ == "__main__":
    main()
