// What is called by name of the native libraries.
using System;
using System.Runtime.InteropServices;

namespace Canwire.Native
{
    /// <summary>Entry points of libvciapi and libcanwire; who calls one has called Loading.Load() before.</summary>
    internal static class Library
    {
        private const string Vci = Loading.Vci;
        private const string Windows = "libcanwire.so";

        [DllImport(Vci)]
        internal static extern int VciInitialize();

        [DllImport(Vci)]
        internal static extern int VciGetVersion(ref VciVersionInfo into);

        [DllImport(Vci)]
        internal static extern int VciFormatErrorA(int code, [Out] byte[] into, uint room);

        [DllImport(Vci)]
        internal static extern int VciGetDeviceManager(out IntPtr into);

        [DllImport(Windows)]
        internal static extern IntPtr CreateEventA(IntPtr rights, int manualReset, int signalled, IntPtr name);

        [DllImport(Windows)]
        internal static extern int SetEvent(IntPtr handle);

        [DllImport(Windows)]
        internal static extern int CloseHandle(IntPtr handle);

        [DllImport(Windows)]
        internal static extern uint WaitForSingleObject(IntPtr handle, uint milliseconds);
    }
}
