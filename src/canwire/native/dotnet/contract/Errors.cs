// Result codes and the exception that carries them. Source: vcierr.h; the vendor's published contract of Ixxat.Vci4.
using System;

#if VCI3
namespace Ixxat.Vci3
#else
namespace Ixxat.Vci4
#endif
{
#if !VCI3
    /// <summary>Result codes, as VciException.HResult has them.</summary>
    public class VciError
    {
        private const uint Error = 0xE0010000;

        public const uint VCI_SUCCESS = 0;
        public const uint VCI_OK = VCI_SUCCESS;
        public const uint VCI_E_UNEXPECTED = Error | 0x01;
        public const uint VCI_E_NOT_IMPLEMENTED = Error | 0x02;
        public const uint VCI_E_OUTOFMEMORY = Error | 0x03;
        public const uint VCI_E_INVALIDARG = Error | 0x04;
        public const uint VCI_E_NOINTERFACE = Error | 0x05;
        public const uint VCI_E_INVPOINTER = Error | 0x06;
        public const uint VCI_E_INVHANDLE = Error | 0x07;
        public const uint VCI_E_ABORT = Error | 0x08;
        public const uint VCI_E_FAIL = Error | 0x09;
        public const uint VCI_E_ACCESSDENIED = Error | 0x0A;
        public const uint VCI_E_TIMEOUT = Error | 0x0B;
        public const uint VCI_E_BUSY = Error | 0x0C;
        public const uint VCI_E_PENDING = Error | 0x0D;
        public const uint VCI_E_NO_DATA = Error | 0x0E;
        public const uint VCI_E_NO_MORE_ITEMS = Error | 0x0F;
        public const uint VCI_E_NOT_INITIALIZED = Error | 0x10;
        public const uint VCI_E_ALREADY_INITIALIZED = Error | 0x11;
        public const uint VCI_E_RXQUEUE_EMPTY = Error | 0x12;
        public const uint VCI_E_TXQUEUE_FULL = Error | 0x13;
        public const uint VCI_E_BUFFER_OVERFLOW = Error | 0x14;
        public const uint VCI_E_INVALID_STATE = Error | 0x15;
        public const uint VCI_E_OBJECT_ALREADY_EXISTS = Error | 0x16;
        public const uint VCI_E_INVALID_INDEX = Error | 0x17;
        public const uint VCI_E_END_OF_FILE = Error | 0x18;
        public const uint VCI_E_DISCONNECTED = Error | 0x19;
        public const uint VCI_E_INVALID_FIRMWARE = Error | 0x1A;
        public const uint VCI_E_WRONG_FLASHFWVERSION = VCI_E_INVALID_FIRMWARE;
        public const uint VCI_E_INVALID_LICENSE = Error | 0x1B;
        public const uint VCI_E_NO_SUCH_LICENSE = Error | 0x1C;
        public const uint VCI_E_LICENSE_EXPIRED = Error | 0x1D;
        public const uint VCI_E_LICENSE_QUOTA_EXCEEDED = Error | 0x1E;
        public const uint VCI_E_INVALID_TIMING = Error | 0x1F;
        public const uint VCI_E_IN_USE = Error | 0x20;
        public const uint VCI_E_NO_SUCH_DEVICE = Error | 0x21;
        public const uint VCI_E_DEVICE_NOT_CONNECTED = Error | 0x22;
        public const uint VCI_E_DEVICE_NOT_READY = Error | 0x23;
        public const uint VCI_E_TYPE_MISMATCH = Error | 0x24;
        public const uint VCI_E_NOT_SUPPORTED = Error | 0x25;
        public const uint VCI_E_DUPLICATE_OBJECTID = Error | 0x26;
        public const uint VCI_E_OBJECTID_NOT_FOUND = Error | 0x27;
        public const uint VCI_E_WRONG_LEVEL = Error | 0x28;
        public const uint VCI_E_WRONG_DRV_VERSION = Error | 0x29;
        public const uint VCI_E_LUIDS_EXHAUSTED = Error | 0x2A;
    }
#endif

    /// <summary>VCI refused; HResult says why.</summary>
    [Serializable]
    public class VciException : Exception
    {
        public VciException(string message) : base(message)
        {
        }

        public VciException(string message, Exception innerException) : base(message, innerException)
        {
        }

#if VCI3
        public VciException(int errorCode) : base(VciServer.GetErrorMsg(errorCode))
        {
            HResult = errorCode;
        }
#else
        public VciException(IVciServer server)
            : this(server, System.Runtime.InteropServices.Marshal.GetHRForLastWin32Error())
        {
        }

        public VciException(IVciServer server, int errorCode) : this(server, "", errorCode)
        {
        }

        public VciException(IVciServer server, string msgappend, int errorCode)
            : base(server.GetErrorMsg(errorCode) + msgappend)
        {
            HResult = errorCode;
        }
#endif

#if VCI3
        /// <summary>The result code.</summary>
        public int ErrorCode
        {
            get { return HResult; }
        }
#endif
    }
}
