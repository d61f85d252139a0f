// A LIN connector's interfaces. Source: VCI V3 .NET manual 4.3; the vendor's published contract of Ixxat.Vci4.
using System;
using System.Threading;

#if VCI3
namespace Ixxat.Vci3.Bal.Lin
#else
namespace Ixxat.Vci4.Bal.Lin
#endif
{
    /// <summary>What a LIN line can do and how it is; any number of programs may have one.</summary>
    public interface ILinSocket : IBalResource
    {
        LinLineStatus LineStatus { get; }

        LinFeatures Features { get; }

        bool SupportsMasterMode { get; }

        bool SupportsAutorate { get; }

        bool SupportsErrorFrames { get; }

        bool SupportsBusLoadComputation { get; }

        /// <summary>In Hz; a tick of time stamps lasts TimeStampCounterDivisor of these.</summary>
        uint ClockFrequency { get; }

        uint TimeStampCounterDivisor { get; }
    }

    /// <summary>What sets a LIN line up and sends on it; one program at a time may have it.</summary>
    public interface ILinControl : ILinSocket
    {
        void InitLine(LinInitLine initLine);

        void ResetLine();

        void StartLine();

        void StopLine();

        /// <summary>Put a message on the bus, or else into the response table; VciException while one is under way.</summary>
#if VCI3
        void WriteMessage(bool send, LinMessage message);
#else
        void WriteMessage(bool send, ILinMessage message);
#endif
    }

    /// <summary>A program's own receive FIFO on a LIN line; inactive, and without a FIFO until Initialize.</summary>
    public interface ILinMonitor : ILinSocket
    {
        LinMonitorStatus MonitorStatus { get; }

        ILinMessageReader GetMessageReader();

        void Initialize(ushort receiveFifoSize, bool exclusive);

        void Activate();

        void Deactivate();
    }

    /// <summary>Takes received messages out of a monitor's FIFO.</summary>
    public interface ILinMessageReader : IDisposable
    {
        ushort Capacity { get; }

        ushort FillCount { get; }

        /// <summary>How many messages have to wait for the event to be set.</summary>
        ushort Threshold { get; set; }

        void AssignEvent(AutoResetEvent fifoEvent);

        void AssignEvent(ManualResetEvent fifoEvent);

#if VCI3
        /// <summary>The oldest message; false if there is none.</summary>
        bool ReadMessage(out LinMessage message);

        /// <summary>Fill this array from its beginning; how many there were.</summary>
        int ReadMessages(LinMessage[] messages);
#else
        /// <summary>The oldest message; false if there is none.</summary>
        bool ReadMessage(out ILinMessage message);

        /// <summary>All that lie together in the FIFO, and how many these are.</summary>
        int ReadMessages(out ILinMessage[] msgarray);
#endif
    }

#if !VCI3
    /// <summary>A LIN message of up to 8 bytes.</summary>
    public interface ILinMessage
    {
        uint TimeStamp { get; set; }

        byte ProtId { get; set; }

        LinMessageType MessageType { get; set; }

        byte DataLength { get; set; }

        bool PossibleOverrun { get; }

        bool ExtendedCrc { get; set; }

        bool SenderOfResponse { get; set; }

        bool IdOnly { get; set; }

        byte this[int index] { get; set; }
    }
#endif
}
