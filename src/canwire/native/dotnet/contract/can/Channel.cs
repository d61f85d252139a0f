// A program's queues on a CAN line. Source: VCI V3 .NET manual 3.1, 4.2.3; the contract of Ixxat.Vci4.
using System;
using System.Threading;

#if VCI3
namespace Ixxat.Vci3.Bal.Can
#else
namespace Ixxat.Vci4.Bal.Can
#endif
{
    /// <summary>A program's own queues on a line; inactive, and without FIFOs until Initialize.</summary>
    public interface ICanChannel : ICanSocket
    {
        CanChannelStatus ChannelStatus { get; }

        /// <summary>One at a time, until its Dispose.</summary>
        ICanMessageReader GetMessageReader();

        ICanMessageWriter GetMessageWriter();

        void Initialize(ushort receiveFifoSize, ushort transmitFifoSize, bool exclusive);

        void Activate();

        void Deactivate();
    }

#if !VCI3
    /// <summary>The same for messages of up to 64 bytes, with a filter of its own.</summary>
    public interface ICanChannel2 : ICanSocket2
    {
        CanChannelStatus ChannelStatus { get; }

        ICanMessageReader GetMessageReader();

        ICanMessageWriter GetMessageWriter();

        void Initialize(ushort receiveFifoSize, ushort transmitFifoSize, uint filterSize, CanFilterModes filterMode,
            bool exclusive);

        void Activate();

        void Deactivate();

        byte GetFilterMode(CanFilter bSelect);

        /// <summary>Returns the mode before.</summary>
        byte SetFilterMode(CanFilter bSelect, CanFilterModes bMode);

        void SetAccFilter(CanFilter bSelect, uint dwCode, uint dwMask);

        void AddFilterIds(CanFilter bSelect, uint dwCode, uint dwMask);

        void RemFilterIds(CanFilter bSelect, uint dwCode, uint dwMask);
    }
#endif

    /// <summary>Takes received messages out of a channel's receive FIFO.</summary>
    public interface ICanMessageReader : IDisposable
    {
        ushort Capacity { get; }

        ushort FillCount { get; }

        /// <summary>How many messages have to wait for the event to be set.</summary>
        ushort Threshold { get; set; }

        void Lock();

        void Unlock();

        void AssignEvent(AutoResetEvent fifoEvent);

        void AssignEvent(ManualResetEvent fifoEvent);

#if VCI3
        /// <summary>The oldest message; false if there is none.</summary>
        bool ReadMessage(out CanMessage message);

        /// <summary>Fill this array from its beginning; how many there were.</summary>
        int ReadMessages(CanMessage[] messages);

        /// <summary>ReadMessage, as the manual's text calls it, too.</summary>
        bool GetMessage(out CanMessage message);

        int GetMessages(CanMessage[] messages);
#else
        /// <summary>The oldest message; false if there is none.</summary>
        bool ReadMessage(out ICanMessage message);

        bool ReadMessage(out ICanMessage2 message);

        /// <summary>All that lie together in the FIFO, and how many these are.</summary>
        int ReadMessages(out ICanMessage[] msgarray);

        int ReadMessages(out ICanMessage2[] msgarray);
#endif
    }

    /// <summary>Puts messages into a channel's transmit FIFO.</summary>
    public interface ICanMessageWriter : IDisposable
    {
        ushort Capacity { get; }

        ushort FreeCount { get; }

        /// <summary>How many messages have to fit for the event to be set.</summary>
        ushort Threshold { get; set; }

        void Lock();

        void Unlock();

        void AssignEvent(AutoResetEvent fifoEvent);

        void AssignEvent(ManualResetEvent fifoEvent);

#if VCI3
        /// <summary>False if there is no room.</summary>
        bool SendMessage(CanMessage message);

        /// <summary>How many of them there was room for, from the first on.</summary>
        int SendMessages(CanMessage[] messages);

        /// <summary>SendMessage, as the manual's text calls it, too.</summary>
        bool WriteMessage(CanMessage message);

        int WriteMessages(CanMessage[] messages);
#else
        /// <summary>False if there is no room.</summary>
        bool SendMessage(ICanMessage message);

        bool SendMessage(ICanMessage2 message);
#endif
    }
}
