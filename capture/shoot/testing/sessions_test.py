#!/usr/bin/env python3
"""Simulated sessions of `keypose shoot`: through faults, Ctrl-C and SIGKILL they end in the project
that an undisturbed session makes, bit for bit.

    sessions_test.py BIN ANGLES [TEST ...]

BIN is the folder of the programs. ANGLES are those of a ring: 24, or 12 for the tests that CMakeLists.txt names.
"""
import json
import os
import random
import shutil
import signal
import subprocess
import time
import unittest

from simulated_sessions import (
    ANGLES,
    Conversation,
    DRAWN,
    Folder,
    INPUT,
    INTERRUPTED,
    LOCKED,
    POSES,
    SCRATCH,
    STAND,
    TOOL,
    USAGE,
    Undisturbed,
    angle,
    contents,
    landed,
    photograph,
    setUpModule,
    shoot,
    shoot_command,
    tearDownModule,
    wait_for_photographs,
)


class Sessions(unittest.TestCase):
    maxDiff = 2000

    def expect_same(self, project, expected, but=""):
        """All files are equal, but for one that is named with a reason."""
        got = contents(project)
        if but:
            got[but] = expected[but]
        self.assertEqual(sorted(got), sorted(expected))
        for name in expected:
            if got[name] != expected[name]:
                self.assertEqual(
                    got[name].decode(errors="replace"),
                    expected[name].decode(errors="replace"),
                    name,
                )

    def test_three_poses_through_five_faults_end_in_the_undisturbed_project(self):
        project = Folder("five").path
        said = shoot(project, "rest", "--faults", "lost-reply@4,stall@9")
        self.assertIn(f"all {ANGLES} photographs", said)
        said = shoot(project, "bent", "--faults", "unplug@11,card-full@7")
        self.assertIn("cable", said)
        self.assertIn("card is full", said)
        process = subprocess.Popen(
            shoot_command(project, "wave"), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL
        )
        wait_for_photographs(project, "wave", ANGLES // 2 + 1)
        process.kill()
        process.wait()
        before = landed(project, "wave")
        self.assertLess(len(before), ANGLES)
        said = shoot(project, "wave")
        self.assertIn("are there already", said)
        after = landed(project, "wave")
        for name, inode in before.items():
            self.assertEqual(after[name], inode, f"{name} was shot twice")
        self.expect_same(project, Undisturbed.of(POSES))

    def test_every_fault_of_both_protocols_ends_in_the_undisturbed_project(self):
        # Apart, because a turn that is started anew counts as a further one.
        faults = (
            "lost-reply@2,lost-line@4,garbage@6,stall@8,unplug@11,reset@15,mute@19,half-file@3,"
            "card-full@5,battery@7,grabbed@9,camera-unplugged@11"
        )
        for turntable in ["simulated", "simulated:grbl"]:
            with self.subTest(turntable=turntable):
                project = Folder("faults_" + turntable.replace(":", "_")).path
                said = shoot(project, "rest", "--faults", faults, turntable=turntable)
                for words in [
                    "by hand until its mark",
                    "only in part",
                    "card is full",
                    "battery is empty",
                    "another program holds",
                    "does not answer",
                ]:
                    self.assertIn(words, said)
                self.expect_same(project, Undisturbed.of(["rest"], turntable))

    def test_killed_at_random_moments_it_goes_on_and_shoots_nothing_twice(self):
        rng = random.Random(19)
        for turntable in ["simulated", "simulated:grbl"]:
            with self.subTest(turntable=turntable):
                project = Folder("killed_" + turntable.replace(":", "_")).path
                kills = 0
                while True:
                    before = landed(project, "rest")
                    process = subprocess.Popen(
                        shoot_command(project, "rest", turntable=turntable),
                        stdin=subprocess.DEVNULL,
                        stdout=subprocess.DEVNULL,
                    )
                    # Some photographs later, at any moment of the next one.
                    more = len(before) + rng.randrange(5)
                    while process.poll() is None and len(landed(project, "rest")) < more:
                        time.sleep(0.002)
                    try:
                        process.wait(timeout=rng.uniform(0, 0.25))
                        self.assertEqual(process.returncode, 0)
                        break
                    except subprocess.TimeoutExpired:
                        process.kill()
                        process.wait()
                        kills += 1
                    after = landed(project, "rest")
                    for name, inode in before.items():
                        self.assertEqual(after[name], inode, f"{name} was shot twice")
                    self.assertLess(kills, 300)
                self.assertGreater(kills, 2)
                self.expect_same(project, Undisturbed.of(["rest"], turntable))

    def test_a_photograph_without_an_entry_is_taken_up(self):
        project = Folder("entry").path
        shoot(project, "rest")
        side = os.path.join(project, "photos", "rest", "shoot.json")
        with open(side) as file:
            root = json.load(file)
        del root["photographs"]["r1_a090"]
        with open(side, "w") as file:
            json.dump(root, file)
        shoot(project, "rest")
        self.expect_same(project, Undisturbed.of(["rest"]))
        os.remove(side)  # even without a side file only the ring is checked anew
        before = landed(project, "rest")
        shoot(project, "rest")
        self.assertEqual(landed(project, "rest"), before)
        self.expect_same(project, Undisturbed.of(["rest"]))

    def test_again_shoots_that_angle_only(self):
        project = Folder("again").path
        shoot(project, "rest")
        before = landed(project, "rest")
        shoot(project, "rest", "--again", str(angle(3)))
        after = landed(project, "rest")
        self.assertEqual([name for name in before if before[name] != after[name]], [photograph(3) + ".jpg"])
        self.expect_same(project, Undisturbed.of(["rest"]), but=STAND)

    def test_a_blurred_photograph_is_found_and_cured_by_shooting_it_again(self):
        project = Folder("blurred").path
        said = shoot(project, "rest", "--faults", "blurred@7")
        self.assertIn("blurred", said)
        side = os.path.join(project, "photos", "rest", "shoot.json")
        with open(side) as file:
            found = json.load(file)["photographs"]
        self.assertEqual([name for name in found if found[name]["findings"]], ["r1_a090"])
        shoot(project, "rest", "--again", "r1_a090")
        self.expect_same(project, Undisturbed.of(["rest"]), but=STAND)

    def test_a_table_turned_by_hand_needs_no_turntable(self):
        project = Folder("hand").path
        said = shoot(project, "rest", turntable="none")
        self.assertIn("turn the table to 345 degrees", said)
        expected = dict(Undisturbed.of(["rest"]))
        side = expected.pop("photos/rest/shoot.json").replace(
            b'"turntable": "simulated"', b'"turntable": "none"'
        )
        self.expect_same(project, {**expected, "photos/rest/shoot.json": side})

    def test_rings_and_flips_ask_for_the_camera_and_the_figure(self):
        # Two rings of twelve on the drawn ring of 24, which stands for both heights.
        project = Folder("flips").path
        drawn = os.path.join(SCRATCH.name, "flips_drawn")
        os.makedirs(drawn)
        for i in range(ANGLES):
            for name in ["IMG", "LYING"]:
                shutil.copy(
                    f"{DRAWN}/photos/rest/IMG_{i + 1:04}.jpg", f"{drawn}/{name}_{i + 1:04}.jpg"
                )
        command = shoot_command(project, "rest")
        command[command.index(f"simulated:{DRAWN}")] = f"simulated:{drawn}"
        command[command.index("--rings") + 1] = "12,40"
        command[command.index("--angles") + 1] = "12"
        done = subprocess.run(
            command + ["--flips", "1"],
            stdin=subprocess.DEVNULL,
            text=True,
            capture_output=True,
            timeout=120,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.count("40 degrees above the table"), 2)
        self.assertEqual(done.stdout.count("lay the figure on its side"), 1)
        names = os.listdir(os.path.join(project, "photos", "rest"))
        self.assertEqual(len([n for n in names if n.startswith("lying_r2_a")]), 12)
        with open(os.path.join(project, "photos", "rest", "shoot.json")) as file:
            entry = json.load(file)["photographs"]["lying_r2_a030"]
        self.assertEqual(
            (entry["flip"], entry["ring"], entry["tilt_deg"], entry["angle_deg"]), (1, 2, 40, 30)
        )

    def test_a_program_drives_it_by_json_lines(self):
        project = Folder("commands").path
        live = os.path.join(SCRATCH.name, "live.jpg")
        talk = Conversation(project, "rest", "--live", live)
        session = talk.until("session")
        self.assertEqual(
            (session["pose"], session["total"], session["done"], session["resumed"]),
            ("rest", ANGLES, 0, False),
        )
        talk.until("state", state="paused")
        talk.say("live", on=True, id=4)
        self.assertEqual(talk.until("accepted")["id"], 4)
        frame = talk.until("live")
        self.assertEqual(frame["path"], live)
        self.assertEqual((frame["width"], frame["height"]), (160, 120))
        talk.say("wave hello", id="x")
        self.assertIn("not known", talk.until("refused")["words"])
        talk.process.stdin.write("{[\n")
        talk.process.stdin.flush()
        talk.until("refused")
        talk.say("shoot")
        photo = talk.until("photograph", photograph=photograph(2))
        self.assertEqual(photo["path"], f"photos/rest/{photograph(2)}.jpg")
        self.assertEqual(photo["entry"]["findings"], [])
        talk.say("pause")
        talk.until("state", state="paused")
        talk.say("again", photograph=photograph(1), id=1)
        talk.until("accepted", id=1)
        self.assertTrue(talk.until("photograph")["again"])
        talk.say("again", angle_deg=17)
        talk.until("refused", command="again")
        talk.say("skip", photograph=photograph(ANGLES - 3))
        talk.until("accepted", command="skip")
        ring = talk.until("ring")
        self.assertEqual(ring["missing_deg"], [angle(ANGLES - 3)])
        self.assertEqual(ring["findings"][0]["code"], "missing")
        talk.until("pose-done", pose="rest", skipped=1)
        talk.until("state", state="idle")
        talk.say("again", photograph=photograph(ANGLES - 3))
        talk.until("photograph", photograph=photograph(ANGLES - 3))
        talk.until("state", state="idle")
        talk.say("next-pose", pose="bent")
        self.assertEqual(talk.until("session", pose="bent")["onion_pose"], "rest")
        self.assertEqual(talk.until("state", state="shooting")["onion"], "photos/rest/r1_a000.jpg")
        talk.until("photograph", photograph=photograph(3))
        ended = talk.end()
        self.assertFalse(ended["complete"])
        self.assertIn("the same command goes on", ended["words"])
        shoot(project, "bent")
        # The ring of `rest` was checked with a gap; that entry stays as it was judged anew.
        self.expect_same(project, Undisturbed.of(["rest", "bent"]))

    def test_a_program_that_goes_away_ends_the_session_cleanly(self):
        project = Folder("gone").path
        talk = Conversation(project, "rest")
        talk.say("shoot")
        talk.until("photograph", photograph="r1_a015")
        talk.process.stdin.close()
        self.assertEqual(talk.process.wait(timeout=30), 0)
        talk.process.stdout.close()
        shoot(project, "rest")
        self.expect_same(project, Undisturbed.of(["rest"]))

    def test_interrupted_by_ctrl_c_it_says_so_and_goes_on_later(self):
        project = Folder("ctrl_c").path
        process = subprocess.Popen(
            shoot_command(project, "rest"),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        wait_for_photographs(project, "rest", 3)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=30)[1]
        self.assertEqual(process.returncode, INTERRUPTED)
        self.assertIn("the same command goes on", said)
        shoot(project, "rest")
        self.expect_same(project, Undisturbed.of(["rest"]))

    def test_one_session_at_a_time(self):
        project = Folder("locked").path
        talk = Conversation(project, "rest")
        talk.until("state", state="paused")
        self.assertIn("another", shoot(project, "rest", expect=LOCKED))
        talk.end()

    def test_the_pose_is_added_to_an_existing_project_and_comments_stay(self):
        project = Folder("yaml").path
        text = (
            "# our hero\nname: hero   # shown\nposes:\n  rest: photos/rest  # first\n"
            "template: rest\n"
        )
        with open(os.path.join(project, "pipeline.yaml"), "w") as file:
            file.write(text)
        talk = Conversation(project, "bent")
        talk.until("session")
        talk.end()
        with open(os.path.join(project, "pipeline.yaml")) as file:
            edited = file.read()
        for line in text.splitlines():
            self.assertIn(line, edited)
        self.assertIn("bent: photos/bent", edited)
        self.assertIn("timeline: [rest, bent]", edited)

    def test_wrong_flags_and_missing_devices_have_their_exit_codes(self):
        project = Folder("wrong").path
        for flags in [
            ["--angles", "2"],
            ["--rings", "12,x"],
            ["--turntable", "lathe"],
            ["--camera", "obscura"],
            ["--faults", "lost-replay@3"],
            ["--again", "7"],
        ]:
            with self.subTest(flags=flags):
                # A flag that is given twice is refused, so what is tried replaces the default.
                command = shoot_command(project, "rest")
                if flags[0] in command:
                    command[command.index(flags[0]) + 1] = flags[1]
                else:
                    command += flags
                done = subprocess.run(
                    command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60
                )
                self.assertEqual(done.returncode, USAGE, done.stderr)
        command = shoot_command(project, "rest", turntable="steps:/dev/no_such_port")
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60
        )
        self.assertEqual(done.returncode, TOOL, done.stderr)
        self.assertIn("/dev/no_such_port", done.stderr)

    def test_another_plan_is_refused_and_further_rings_are_not(self):
        project = Folder("plan").path
        talk = Conversation(project, "rest")
        talk.say("shoot")
        talk.until("photograph")
        talk.end()
        command = shoot_command(project, "rest")
        command[command.index("--angles") + 1] = "12"
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60
        )
        self.assertEqual(done.returncode, INPUT, done.stderr)
        self.assertIn("was begun with --rings 12 --angles 24", done.stderr)
        command = shoot_command(project, "rest", "--commands")
        command[command.index("--rings") + 1] = "12,40"
        done = subprocess.run(command, input="", capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        session = json.loads(done.stdout.splitlines()[0])
        self.assertEqual((session["total"], session["resumed"]), (2 * ANGLES, True))


if __name__ == "__main__":
    unittest.main()
