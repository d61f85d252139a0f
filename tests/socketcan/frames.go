// One frame sent and one received on can0, by the calls of Go's own syscall package.
package main

import (
	"fmt"
	"net"
	"os"
	"syscall"
	"unsafe"
)

func check(err error) {
	if err != nil {
		fmt.Fprintln(os.Stderr, err)
		os.Exit(1)
	}
}

func main() {
	device, err := net.InterfaceByName("can0")
	check(err)
	wire, err := syscall.Socket(29, syscall.SOCK_RAW, 1)
	check(err)
	address := struct {
		family uint16
		_      uint16
		index  int32
		_      [16]byte
	}{family: 29, index: int32(device.Index)}
	_, _, number := syscall.Syscall(syscall.SYS_BIND, uintptr(wire), uintptr(unsafe.Pointer(&address)), 24)
	if number != 0 {
		check(number)
	}
	frame := make([]byte, 16)
	copy(frame, []byte{0x23, 1, 0, 0, 2, 0, 0, 0, 'G', 'o'})
	_, err = syscall.Write(wire, frame)
	check(err)
	_, err = syscall.Read(wire, frame)
	check(err)
	fmt.Printf("%s %d %d: %X %X\n", device.Name, device.Index, device.MTU, int(frame[1])<<8|int(frame[0]), frame[8])
}
