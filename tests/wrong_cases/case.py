"""What a case of wrong_projects.py is, and what cases are made of."""
import dataclasses
import typing

USAGE, INPUT, DISK, TOOL, GATE, LOCKED = 2, 3, 4, 5, 6, 7
POSES = 'poses:\n  rest: photos/rest\n  bent: photos/bent\n'
# Faults are in the photographs of `rest`; capturing the other pose too would show nothing more.
STATUS, CAPTURE = ('status',), ('run', '--until', 'capture/rest')


@dataclasses.dataclass
class Case:
    name: str
    code: int
    words: tuple
    command: tuple = STATUS
    yaml: typing.Optional[str] = None  # replaces the project's pipeline.yaml
    spoil: typing.Optional[typing.Callable] = None  # gets the project's folder
    outside: bool = False  # the command gets no -C
    environment: dict = dataclasses.field(default_factory=dict)


def write(path, data):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


def photographs(folder, pose='rest'):
    return sorted((folder / 'photos' / pose).glob('*.jpg'))


def png(width, height, payload=b''):
    import struct
    import zlib

    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))
    return (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', width, height, 8, 2, 0, 0, 0)) + chunk(b'IDAT', zlib.compress(payload))
            + chunk(b'IEND', b''))


def whole_png(width, height, grey):
    return png(width, height, (b'\0' + bytes([grey]) * 3 * width) * height)
