//! `--cluster`: the processes that `mpirun` started.

use super::Arguments;
use crate::cli::prelude::*;
use crate::live::{SingleMachine, SwapLock};

/// Joins the other processes, if there are any.
pub(super) fn lock(arguments: &Arguments) -> Result<Box<dyn SwapLock>, Failure> {
    if arguments.cluster {
        return join(Duration::from_secs(arguments.swap_timeout));
    }
    match started_by_mpirun() {
        None | Some(1) => Ok(Box::new(SingleMachine)),
        Some(processes) => Err(misuse!(
            "mpirun started {processes} of these, and each would follow the tracker by itself: \
             give --cluster, which shares the walls among them"
        )),
    }
}

/// Returns the number of processes that `mpirun` started, as Open MPI and MPICH say it.
fn started_by_mpirun() -> Option<usize> {
    let names = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"];
    let said = names.into_iter().find_map(|name| std::env::var(name).ok());
    said.and_then(|said| said.parse().ok())
}

#[cfg(feature = "cluster")]
fn join(wait: Duration) -> Result<Box<dyn SwapLock>, Failure> {
    use crate::live::{Cluster, Mpi};
    let joined = Mpi::join().and_then(|mpi| Cluster::new(mpi, wait));
    Ok(Box::new(joined.map_err(Failure::from_error)?))
}

#[cfg(not(feature = "cluster"))]
fn join(_: Duration) -> Result<Box<dyn SwapLock>, Failure> {
    Err(misuse!(
        "--cluster is not in this program: build it with `cargo build --release --features \
         cluster`, for which Open MPI and clang are needed (on Debian: libopenmpi-dev \
         openmpi-bin clang libclang-dev)"
    ))
}
