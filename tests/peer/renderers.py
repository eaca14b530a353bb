"""What pairs.py and duel.py call: Tessera's command line, and Blender's."""
import os
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent


def blender(script, *words):
    return ["blender", "-b", "--factory-startup", "--python-exit-code", "1", "-P", str(HERE / "blender" / script), "--", *map(str, words)]


# Another Python first on the PATH would keep Blender from its numpy.
BLENDERS_PATH = {"PATH": "/usr/bin:/bin"}


def run(command, log, **environment):
    """What it printed. All that it says is left in the log."""
    with open(log, "w", encoding="utf-8") as file:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=file, text=True, env={**os.environ, **environment}, check=False)
        file.write(done.stdout)
    if done.returncode:
        sys.exit(f"{sys.argv[0]}: {command[0]} failed, and said so in {log}")
    return done.stdout


def tessera(options, scene, output, samples, seed, environment=None, rotate=0, frame=1):
    """options: bin, size, bounces, threads."""
    command = [options.bin / "tessera", "--json", "render", scene, "-o", output, "--size", options.size, "--samples", samples, "--bounces",
               options.bounces, "--filter", "box", "--seed", seed, "--threads", options.threads, "--frames", frame]
    if environment:
        command += ["--env", environment, "--env-rotate", rotate]
    return [str(word) for word in command]
