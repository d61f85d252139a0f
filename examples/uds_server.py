"""A small UDS server under test, in virtual time: python examples/uds_server.py"""

from __future__ import annotations

from canwire import Frame, Lab, NodeScript

REQUEST, RESPONSE = 0x7E0, 0x7E8
VIN_PART = {0xF18C: b"C42"}  # what this server can be asked for
SESSION, READ, TESTER_PRESENT = 0x10, 0x22, 0x3E
REQUEST_OUT_OF_RANGE, SERVICE_NOT_SUPPORTED = 0x31, 0x11


class UdsServer(NodeScript):
    """Answers single frames after 5 ms (ISO 14229-1); back to the default session after 5 s of silence."""

    def on_start(self) -> None:
        self.fall_back()
        self.silence = self.after(5.0, self.fall_back)

    def on_message(self, frame: Frame) -> None:
        if frame.id != REQUEST:
            return
        self.silence.cancel()
        self.silence = self.after(5.0, self.fall_back)
        answer = self.answer(frame.data[1 : 1 + frame.data[0]])
        self.after(0.005, lambda: self.send(Frame(RESPONSE, bytes([len(answer)]) + answer)))

    def answer(self, request: bytes) -> bytes:
        if request[0] == SESSION:
            self.session = request[1]
            return bytes([SESSION + 0x40, self.session])
        if request[0] == TESTER_PRESENT:
            return bytes([TESTER_PRESENT + 0x40, 0])
        if request[0] == READ:
            found = VIN_PART.get(int.from_bytes(request[1:3], "big"))
            return b"\x62" + request[1:3] + found if found else bytes([0x7F, READ, REQUEST_OUT_OF_RANGE])
        return bytes([0x7F, request[0], SERVICE_NOT_SUPPORTED])

    def fall_back(self) -> None:
        self.session = 1


def main() -> list[str]:
    """What the server answers, and its session six silent seconds later."""
    with Lab() as lab:
        bus, server = lab.can_bus("can0", bit_rate=500_000), UdsServer()
        bus.node("ecu", server)
        tester = bus.node("tester", filters=[(RESPONSE, 0x7FF)])
        answers = []
        for request in ("02 10 03", "03 22 f1 8c", "03 22 12 34", "01 85"):
            tester.send(Frame(REQUEST, bytes.fromhex(request)))
            answers.append(tester.expect(RESPONSE, within=0.05).data.hex(" "))
            print(f"{request:<12} -> {answers[-1]}")
        lab.run_for(6.0)
        print(f"session {server.session} after six silent seconds")
    return [*answers, f"session {server.session}"]


if __name__ == "__main__":
    main()
