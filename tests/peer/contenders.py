"""The two renderers of duel.py. Each renders a scene with one seed after another and keeps account of what that took."""
import json
import os
import pathlib
import statistics
import subprocess
import sys
import threading

from renderers import BLENDERS_PATH, blender, run, tessera


def file_of(options, scene, suffix):
    return options.folder / f"{scene['name']}.{suffix}"


def pixels_of(options):
    width, height = map(int, options.size.split("x"))
    return width * height


class Contender:
    """times: (seconds, CPU seconds) of each render. What a render of one sample takes, `base`, is taken off both, and so what is there
    however many samples there are: our seconds begin with the first task, for which a worker loads the scene; the CPU seconds are of all
    that the program did."""
    base_rounds = 3

    def __init__(self, scene, options, name):
        self.scene, self.options, self.name = scene, options, name
        self.samples = options.samples
        self.pictures, self.times, self.base = [], [], []

    def pilot(self):
        """The seconds of one sample of all pixels, by one try."""
        one, many = (self.render_once(samples, 0, file_of(self.options, self.scene, f"{self.name}.pilot.exr"))[0]
                     for samples in (1, self.samples))
        return (many - one) / (self.samples - 1)

    def render(self, seed):
        picture = file_of(self.options, self.scene, f"{self.name}.{seed}.exr")
        self.times.append(self.render_once(self.samples, seed, picture))
        self.pictures.append(picture)
        if len(self.base) < self.base_rounds:
            self.base.append(self.render_once(1, seed, file_of(self.options, self.scene, f"{self.name}.one.exr")))

    def measured(self):
        """Seconds and CPU seconds are of one sample of all pixels."""
        seconds, cpu_seconds = (
            (statistics.fmean(time[clock] for time in self.times) - statistics.fmean(time[clock] for time in self.base)) / (self.samples - 1)
            for clock in (0, 1))
        return {"samples": self.samples, "pixels": pixels_of(self.options), "seconds": seconds, "cpu_seconds": cpu_seconds,
                "load": self.load, "memory": self.memory}


class Tessera(Contender):
    """Each render starts a coordinator and a worker, as a person's does. Memory is all three programs', the most of each."""

    def __init__(self, scene, options):
        super().__init__(scene, options, "ours")
        self.file = file_of(options, scene, "glb")
        told = run([str(options.bin / "bench_load_once"), str(self.file), str(options.threads)], file_of(options, scene, "load.log"))
        self.load = sum(map(float, told.split()[:2]))
        self.memory = 0

    def render_once(self, samples, seed, picture):
        around = self.scene.get("environment")
        command = tessera(self.options, self.file, picture, samples, seed, self.options.folder / around if around else None)
        with open(file_of(self.options, self.scene, "ours.log"), "w", encoding="utf-8") as log:
            program = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True)
            watch = None
            if not self.times:
                watch = Memory(program.pid)
            told = program.stdout.read()
            _, status, used = os.wait4(program.pid, 0)  # with what it waited for: the coordinator, the worker
        if status:
            sys.exit(f"duel.py: tessera failed, and said so in {log.name}")
        if watch:
            self.memory = watch.ended()
        return json.loads(told.strip().splitlines()[-1])["render_seconds"], used.ru_utime + used.ru_stime

    def end(self):
        pass


class Memory:
    """Looks at a program and its children while they run."""

    def __init__(self, program):
        self.program, self.most, self.over = program, {}, threading.Event()
        self.thread = threading.Thread(target=self.look)
        self.thread.start()

    def look(self):
        while not self.over.wait(0.01):
            for process in [self.program, *children(self.program)]:
                try:
                    status = pathlib.Path(f"/proc/{process}/status").read_text(encoding="ascii")
                except OSError:
                    continue  # it has ended
                for line in status.splitlines():
                    if line.startswith("VmHWM"):
                        self.most[process] = int(line.split()[1]) / 1024

    def ended(self):
        """The sum, MiB."""
        self.over.set()
        self.thread.join()
        return sum(self.most.values())


def children(process):
    try:
        return [int(word) for file in pathlib.Path(f"/proc/{process}/task").glob("*/children") for word in file.read_text().split()]
    except OSError:
        return []


class Cycles(Contender):
    """One Blender for all seeds of a scene. Its memory is the whole program's."""

    def __init__(self, scene, options):
        super().__init__(scene, options, "cycles")
        width, height = map(int, options.size.split("x"))
        job = {"scene": str(file_of(options, scene, "glb")), "width": width, "height": height, "bounces": options.bounces,
               "threads": options.threads}
        if "environment" in scene:
            job["environment"] = str(options.folder / scene["environment"])
        file = file_of(options, scene, "cycles.json")
        file.write_text(json.dumps(job))
        self.log = open(file_of(options, scene, "cycles.log"), "w", encoding="utf-8")
        self.program = subprocess.Popen(blender("duel.py", file), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.log, text=True,
                                        env={**os.environ, **BLENDERS_PATH})
        self.load, self.memory, self.spent = self.told()[0], 0, None

    def told(self):
        for line in self.program.stdout:
            self.log.write(line)
            if line.startswith("measured "):
                return [float(word) for word in line.split()[1:]]
        sys.exit(f"duel.py: blender failed, and said so in {self.log.name}")

    def ask(self, samples, seed, picture):
        self.program.stdin.write(f"{samples} {seed} {picture}\n")
        self.program.stdin.flush()
        return self.told()

    def render_once(self, samples, seed, picture):
        if self.spent is None:  # the first render synchronizes the scene
            _, synchronization, self.spent, _ = self.ask(1, seed, picture)
            self.load += synchronization
        seconds, _, spent, self.memory = self.ask(samples, seed, picture)
        used, self.spent = spent - self.spent, spent
        return seconds, used

    def end(self):
        self.program.stdin.close()
        self.program.wait()
        self.log.close()
