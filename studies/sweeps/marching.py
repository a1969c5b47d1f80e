"""Points marched by processes of this computer, or on the workers of a dask scheduler."""

from collections.abc import Iterable, Iterator

from bladewhirl.studies.sweeps.points import Outcome, Point, Work
from bladewhirl.studies.sweeps.workers import march_in_processes


def march_points(
    work: Work, points: Iterable[Point | None], *, scheduler: str | None, workers: int | None
) -> Iterator[tuple[int, Outcome]]:
    """March points; yield the number and the outcome of each point as the outcome arrives.

    Args:
        work: data common to all points.
        points: points to march. None means that no point can be marched before the outcome of
            another one has been yielded.
        scheduler: address of a dask scheduler, whose workers march; None for this computer.
        workers: number of processes of this computer; one per core when None.

    Raises:
        UserError: the scheduler does not answer, has no TLS, or its workers have another version.
    """
    if scheduler is None:
        yield from march_in_processes(work, points, workers)
        return
    from bladewhirl.studies.sweeps.cluster import march_on_cluster  # dask is optional

    yield from march_on_cluster(work, points, scheduler)
