//! What crosses the crates, in one program: each would else compile the tracer
//! again, and take as long to link as to run.

mod blob_errors;
mod blob_fuzz;
mod brute_force;
mod capture;
mod clear;
mod command;
mod command_faults;
mod determinism;
mod dispersion;
mod dome;
mod dome_command;
mod dome_screen;
mod effects;
mod environment;
mod exact;
mod examples;
mod fill;
mod frame_job;
mod fuzz_targets;
#[expect(unreachable_pub, reason = "a library of its own for the fuzz targets")]
#[path = "../fuzz/src/lib.rs"]
mod fuzzed;
mod gaze;
mod gaze_command;
mod golden;
mod levels;
mod live;
mod live_command;
mod lod;
mod microfacets;
mod normal_maps;
mod optics;
#[cfg(unix)]
mod outputs;
mod overrun;
mod paper_rays;
mod poses;
mod replay;
mod scene_fuzz;
mod shadows;
mod soft_light;
mod spectrum;
mod stereo;
mod textures;
mod tracker_calibration;
mod tracker_command;
mod tracker_fuzz;
mod tracker_recording;
mod tracker_replay;
mod tradeoff_command;
mod watertight;
mod window;
