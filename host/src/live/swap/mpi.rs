//! Messages by MPI: feature `cluster`.

use super::SwapError;
use super::cluster::Wire;
use ::mpi::Threading;
use ::mpi::datatype::Equivalence as _;
use ::mpi::environment::{Universe, initialize_with_threading, processor_name};
use ::mpi::point_to_point::{Destination, Source};
use ::mpi::topology::{Communicator, SimpleCommunicator};
use std::fmt;

const STARTED: &str = "MPI cannot be started: it has been started before";

/// The processes that `mpirun` started.
pub struct Mpi {
    world: SimpleCommunicator,
    /// Kept because MPI does not tell its rank once it has ended.
    rank: usize,
    ranks: usize,
    universe: Option<Universe>,
}

impl fmt::Debug for Mpi {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Mpi").finish_non_exhaustive()
    }
}

impl Mpi {
    /// Joins the processes; without `mpirun` this process is alone. Once in a program.
    ///
    /// # Errors
    /// A second call.
    pub fn join() -> Result<Self, SwapError> {
        // One thread sends and receives.
        let joined = initialize_with_threading(Threading::Funneled);
        let (universe, _) = joined.ok_or_else(|| SwapError(STARTED.to_owned()))?;
        let world = universe.world();
        Ok(Self {
            rank: world.rank() as usize,
            ranks: world.size() as usize,
            world,
            universe: Some(universe),
        })
    }
}

impl Wire for Mpi {
    fn rank(&self) -> usize {
        self.rank
    }

    fn ranks(&self) -> usize {
        self.ranks
    }

    fn name(&self) -> String {
        processor_name().unwrap_or_else(|_| "a machine without a name".to_owned())
    }

    /// Messages are short enough for any MPI to send at once.
    fn send(&mut self, to: usize, message: &[u8]) {
        self.world.process_at_rank(to as i32).send(message);
    }

    fn poll(&mut self, from: usize) -> Option<Vec<u8>> {
        let from = self.world.process_at_rank(from as i32);
        let status = from.immediate_probe()?;
        let mut message = vec![0; status.count(u8::equivalent_datatype()) as usize];
        from.receive_into(&mut message[..]);
        Some(message)
    }

    /// Waits for all machines.
    fn finish(&mut self) {
        self.universe = None;
    }
}

impl Drop for Mpi {
    fn drop(&mut self) {
        // After a failure this process does not wait for the others: mpirun ends them.
        std::mem::forget(self.universe.take());
    }
}
