//! Temporary.
#![no_std]
#![no_main]
use core::panic::PanicInfo;
use cortex_m_rt::entry;
use cortex_m as _;
use cortex_m_semihosting::{debug, hprintln};
use shisen_core::frame::*;
use shisen_tracker::*;
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! { loop {} }
#[entry]
fn main() -> ! {
    core::mem::forget(cortex_m::Peripherals::take());
    hprintln!("view {} renderer {} part {} workspace {} job {} place {} budget {}", size_of::<View>(), size_of::<Renderer<4>>(), size_of::<Part<4>>(), size_of::<Workspace>(), size_of::<FrameJob>(), size_of::<Place>(), size_of::<Budget>());
    hprintln!("gaze {} estimator {} config {} clock {} link {} session {} watch {} script {}", size_of::<shisen_core::gaze::Gaze>(), size_of::<estimate::GazeEstimator>(), size_of::<estimate::EstimatorConfig>(), size_of::<clock::ClockEstimator>(), size_of::<link::Link>(), size_of::<command::Session>(), size_of::<command::Watch>(), size_of::<command::Script>());
    hprintln!("sample {} event {} estimate {} estevent {} frame {}", size_of::<sample::Sample>(), size_of::<decoder::Event>(), size_of::<estimate::Estimate>(), size_of::<estimate::Event>(), size_of::<link::Frame>());
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}
