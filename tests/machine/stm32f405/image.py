"""The ELF file of the image: what is programmed, names and source lines."""

import bisect
import io
import pathlib

from elftools.elf.elffile import ELFFile


class Image:
    def __init__(self, path):
        self.path = str(path)
        #: Read when they are needed: debug information, and the lines of its units.
        self.dwarf, self.lines = None, {}
        with open(path, "rb") as file:
            elf = ELFFile(file)
            self.segments = [
                (segment["p_paddr"], segment.data())
                for segment in elf.iter_segments()
                if segment["p_type"] == "PT_LOAD" and segment["p_filesz"]
            ]
            symbols = list(elf.get_section_by_name(".symtab").iter_symbols())
        functions = [s for s in symbols if s["st_info"]["type"] == "STT_FUNC"]
        self.functions = sorted((s["st_value"] & ~1, s.name) for s in functions)
        self.symbols = {s.name: s["st_value"] for s in symbols}

    def __deepcopy__(self, _memo):
        return self

    def function(self, address):
        """The function that an address lies in."""
        i = bisect.bisect_right(self.functions, (address & ~1, "~")) - 1
        return self.functions[i][1] if i >= 0 else "?"

    def find(self, part):
        """The address of the only function whose name has this part."""
        found = {a for a, name in self.functions if part in name}
        assert len(found) == 1, f"{len(found)} functions are called {part}"
        return found.pop()

    def where(self, address):
        """Address, function, file and line."""
        line = self.line(address & ~1)
        return f"{address & ~1:#010x} {self.function(address)}" + (f" ({line})" if line else "")

    def line(self, address):
        # Read only when there is something to tell: debug information is large.
        if self.dwarf is None:
            self.dwarf = ELFFile(io.BytesIO(pathlib.Path(self.path).read_bytes())).get_dwarf_info()
        ranges = self.dwarf.get_aranges()
        offset = ranges.cu_offset_at_addr(address) if ranges else None
        if offset is None:
            return None
        if offset not in self.lines:
            self.lines[offset] = self.lines_of(self.dwarf.get_CU_at(offset))
        lines = self.lines[offset]
        i = bisect.bisect_right(lines, address, key=lambda line: line[0]) - 1
        return lines[i][1] if i >= 0 else None

    def lines_of(self, unit):
        """Addresses of a unit in their order, each with its file and line."""
        program = self.dwarf.line_program_for_CU(unit)
        if program is None:
            return []
        files, first = program["file_entry"], 0 if program["version"] >= 5 else 1
        states = [entry.state for entry in program.get_entries()]
        lines = [(state.address, state.file, state.line) for state in states if state is not None and not state.end_sequence]
        lines.sort(key=lambda line: line[0])
        return [(address, f"{files[file - first].name.decode()}:{line}") for address, file, line in lines]
