//! Messages by MPI: feature `cluster`.

use super::SwapError;
use super::cluster::Wire;
use ::mpi::Threading;
use ::mpi::datatype::Equivalence as _;
use ::mpi::environment::{Universe, initialize_with_threading, processor_name};
use ::mpi::point_to_point::{Destination, Source};
use ::mpi::topology::{Communicator, SimpleCommunicator};
use std::fmt;

/// The processes that `mpirun` started.
pub struct Mpi {
    world: SimpleCommunicator,
    /// What MPI does not say any more once it has ended.
    rank: usize,
    ranks: usize,
    universe: Option<Universe>,
}

impl fmt::Debug for Mpi {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Mpi")
            .field("rank", &self.rank)
            .field("ranks", &self.ranks)
            .finish_non_exhaustive()
    }
}

impl Mpi {
    /// Joins them; without `mpirun` this process is alone. Once in a program.
    ///
    /// # Errors
    /// It was joined before.
    pub fn join() -> Result<Self, SwapError> {
        // Messages are the business of one thread.
        let joined = initialize_with_threading(Threading::Funneled);
        let (universe, _) =
            joined.ok_or_else(|| SwapError::Mpi("it has been started before".to_owned()))?;
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

    /// A message is shorter than what any MPI sends at once, whoever waits for it.
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

    /// Waits until all have come here.
    fn finish(&mut self) {
        self.universe = None;
    }
}

impl Drop for Mpi {
    fn drop(&mut self) {
        // Who ends before the others does not wait for them: mpirun ends them as soon as
        // this process fails.
        std::mem::forget(self.universe.take());
    }
}
