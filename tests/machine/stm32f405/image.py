"""The ELF file of the image: what is programmed, names and source lines."""

import bisect

from elftools.elf.elffile import ELFFile


class Image:
    def __init__(self, path):
        self.path = str(path)
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
        with open(self.path, "rb") as file:
            dwarf = ELFFile(file).get_dwarf_info()
            ranges = dwarf.get_aranges()
            offset = ranges.cu_offset_at_addr(address) if ranges else None
            if offset is None:
                return None
            program = dwarf.line_program_for_CU(dwarf.get_CU_at(offset))
            if program is None:
                return None
            best = None
            for entry in program.get_entries():
                state = entry.state
                if state is None or state.end_sequence or state.address > address:
                    continue
                if best is None or state.address >= best.address:
                    best = state
            if best is None:
                return None
            files, first = program["file_entry"], 0 if program["version"] >= 5 else 1
            return f"{files[best.file - first].name.decode()}:{best.line}"
