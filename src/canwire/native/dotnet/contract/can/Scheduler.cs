// A line's cyclic list. Source: VCI V3 .NET manual 4.2.5; the vendor's published contract of Ixxat.Vci4.
#if VCI3
namespace Ixxat.Vci3.Bal.Can
{
    /// <summary>Up to 16 messages that a line sends again and again; stopped at first. One program at a time may have it.</summary>
    public interface ICanScheduler : ICanSocket
    {
        void Suspend();

        void Resume();

        /// <summary>Stop the list and take all messages off it.</summary>
        void Reset();

        /// <summary>Look at the list; nothing else changes Status of its messages.</summary>
        void UpdateStatus();

        /// <summary>Put a copy of this message on the list, idle until StartMessage.</summary>
        void AddMessage(CanCyclicTXMsg message);

        void RemoveMessage(CanCyclicTXMsg message);

        /// <summary>Send it so many times, or for ever with 0, once the list runs.</summary>
        void StartMessage(CanCyclicTXMsg message, ushort repeatCount);

        void StopMessage(CanCyclicTXMsg message);
    }
}
#else
namespace Ixxat.Vci4.Bal.Can
{
    /// <summary>Up to 16 messages that a line sends again and again; it runs. One program at a time may have it.</summary>
    public interface ICanScheduler : ICanSocket
    {
        void Suspend();

        void Resume();

        /// <summary>Stop the list and take all messages off it.</summary>
        void Reset();

        void UpdateStatus();

        /// <summary>A new message of this list, to be filled in and started.</summary>
        ICanCyclicTXMsg AddMessage();
    }

    /// <summary>A message of a cyclic list; what is changed while it is sent counts from the next Start on.</summary>
    public interface ICanCyclicTXMsg : ICanMessage
    {
        CanCyclicTXStatus Status { get; }

        ushort CycleTicks { get; set; }

        CanCyclicTXIncMode AutoIncrementMode { get; set; }

        byte AutoIncrementIndex { get; set; }

        /// <summary>Send it so many times, or for ever with 0.</summary>
        void Start(ushort repeatCount);

        void Stop();

        void Reset();
    }

    /// <summary>The cyclic list of a CAN FD line.</summary>
    public interface ICanScheduler2 : ICanSocket2
    {
        void Suspend();

        void Resume();

        void Reset();

        void UpdateStatus();

        ICanCyclicTXMsg2 AddMessage();
    }

    /// <summary>A cyclic message of up to 64 bytes.</summary>
    public interface ICanCyclicTXMsg2 : ICanMessage2
    {
        CanCyclicTXStatus Status { get; }

        ushort CycleTicks { get; set; }

        CanCyclicTXIncMode AutoIncrementMode { get; set; }

        byte AutoIncrementIndex { get; set; }

        void Start(ushort repeatCount);

        void Stop();

        void Reset();
    }
}
#endif
