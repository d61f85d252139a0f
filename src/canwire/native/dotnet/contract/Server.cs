// Where everything starts. Source: VCI V3 .NET manual 2.1, 2.2; the vendor's published contract of Ixxat.Vci4.
using System;
using System.Collections;
using System.Threading;

#if VCI3
namespace Ixxat.Vci3
#else
namespace Ixxat.Vci4
#endif
{
#if !VCI3
    /// <summary>The server, of which there is one: VciServer.Instance().</summary>
    public interface IVciServer
    {
        /// <summary>VCI's version.</summary>
        Version Version { get; }

        /// <summary>A new manager, to be disposed of.</summary>
        IVciDeviceManager DeviceManager { get; }

        IMessageFactory MsgFactory { get; }

        /// <summary>Name, number and meaning of a result code.</summary>
        string GetErrorMsg(int errorCode);
    }

    /// <summary>Makes messages.</summary>
    public interface IMessageFactory
    {
        /// <summary>An empty ICanMessage, ICanMessage2 or ILinMessage; ArgumentException for another type.</summary>
        object CreateMsg(Type msgtyp);
    }
#endif

    /// <summary>Knows the boards.</summary>
    public interface IVciDeviceManager : IDisposable
    {
        IVciDeviceList GetDeviceList();
    }

    /// <summary>The boards that are plugged in; each enumerator goes through them by itself.</summary>
    public interface IVciDeviceList : IEnumerable, IDisposable
    {
        /// <summary>Set this event whenever a board comes or goes, in place of the event before.</summary>
        void AssignEvent(AutoResetEvent changeEvent);

        void AssignEvent(ManualResetEvent changeEvent);
    }
}
