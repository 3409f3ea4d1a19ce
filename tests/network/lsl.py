"""Streams of LSL, by liblsl: an outlet of ours is read, and an outlet of it is."""

import json
import math
import subprocess
import sys
import threading
import time

import pylsl

shisen = sys.argv[1]


def theirs():
    """An outlet of liblsl, read by `shisen tracker monitor`."""
    labels = ["gaze_direction_x", "gaze_direction_y", "gaze_direction_z", "confidence"]
    info = pylsl.StreamInfo("eyes-of-liblsl", "Gaze", len(labels), 200, "float32", "test")
    channels = info.desc().append_child("channels")
    for label in labels:
        channels.append_child("channel").append_child_value("label", label)
    outlet = pylsl.StreamOutlet(info)
    over = threading.Event()

    def send():
        count = 0
        while not over.is_set():
            angle = 0.001 * (count % 400 - 200)
            confidence = 0.1 if count % 10 == 0 else 0.9
            outlet.push_sample([math.sin(angle), 0.0, -math.cos(angle), confidence])
            count += 1
            time.sleep(0.005)

    sender = threading.Thread(target=send)
    sender.start()
    words = [shisen, "tracker", "monitor", "lsl:name=eyes-of-liblsl", "--json"]
    try:
        run = subprocess.run(words + ["--frames", "600", "--seconds", "30"],
                             capture_output=True, text=True, timeout=60)
    finally:
        over.set()
        sender.join()
    assert run.returncode == 0, run.stderr
    records = [json.loads(line) for line in run.stdout.splitlines()]
    assert len(records) == 600, len(records)
    seen = [one["combined"]["direction"] for one in records]
    lost = sum(not one["tracked"] for one in seen)
    assert 50 <= lost <= 70, lost
    for one in seen:
        if one["tracked"]:
            x, y, z = one["value"]
            assert abs(x * x + y * y + z * z - 1) < 1e-5 and abs(x) < 0.21 and y == 0
    steps = [b["device_us"] - a["device_us"] for a, b in zip(records, records[1:])]
    assert min(steps) > 0
    # The clock was asked for: the delay is known, and small on one machine.
    late = sorted(one["late_us"] for one in records[400:] if one["late_us"] is not None)
    print(f"liblsl's outlet: 600 samples, {lost} of low confidence, "
          f"from push to arrival {late[len(late) // 2]} us at the median")
    assert late[len(late) // 2] < 2000, late


def ours():
    """An outlet of `shisen tracker serve`, read by liblsl."""
    words = [shisen, "tracker", "serve", "mock:rate=200", "--as", "lsl?name=eyes-of-shisen"]
    server = subprocess.Popen(words, stderr=subprocess.DEVNULL)
    try:
        found = pylsl.resolve_byprop("name", "eyes-of-shisen", timeout=20)
        assert len(found) == 1, found
        inlet = pylsl.StreamInlet(found[0], max_buflen=60)
        info = inlet.info(timeout=10)
        channel, labels = info.desc().child("channels").child("channel"), []
        for _ in range(info.channel_count()):
            labels.append(channel.child_value("label"))
            channel = channel.next_sibling("channel")
        assert labels[:3] == [f"gaze_direction_{axis}" for axis in "xyz"], labels
        off = inlet.time_correction(timeout=10)
        samples = [inlet.pull_sample(timeout=5) for _ in range(400)]
        late = []
        for values, stamp in samples:
            assert values is not None
            x, y, z = values[:3]
            if values[3] == 1.0:
                assert abs(x * x + y * y + z * z - 1) < 1e-5
            late.append(pylsl.local_clock() - (stamp + off))
        stamps = [stamp for _, stamp in samples]
        assert all(a < b for a, b in zip(stamps, stamps[1:]))
        rate = 399 / (stamps[-1] - stamps[0])
        assert abs(rate - 200) < 10, rate
        print(f"shisen's outlet: 400 samples at {rate:.1f} Hz by liblsl")
    finally:
        server.terminate()
        server.wait()


theirs()
ours()
