"""What a render in Blender took."""
import re


def header_seconds(picture, what):
    """From the header of an EXR file that Cycles wrote, hours:minutes:seconds: "synchronization" or "render"."""
    with open(picture, "rb") as file:
        found = re.search(what.encode() + rb"_time\0string\0.{4}([0-9:.]+)", file.read(1 << 16), re.DOTALL)
    seconds = 0.0
    for part in found[1].decode().split(":"):
        seconds = 60 * seconds + float(part)
    return seconds


def peak_memory():
    """Of this process, MiB."""
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) / 1024 for line in file if line.startswith("VmHWM"))
