// CAN messages. Source: the vendor's published contract of Ixxat.Vci4.
namespace Ixxat.Vci4.Bal.Can
{
    /// <summary>A CAN message of up to 8 bytes.</summary>
    public interface ICanMessage
    {
        /// <summary>Received: ticks of the time stamps. To send: ticks of the delay after the message before, or 0.</summary>
        uint TimeStamp { get; set; }

        uint Identifier { get; set; }

        /// <summary>Only Data is sent.</summary>
        CanMsgFrameType FrameType { get; set; }

        CanMsgAccReason AcceptReason { get; }

        /// <summary>In bytes; ArgumentOutOfRangeException for more than there can be.</summary>
        byte DataLength { get; set; }

        /// <summary>Messages were lost just before this one.</summary>
        bool PossibleOverrun { get; }

        bool SelfReceptionRequest { get; set; }

        bool RemoteTransmissionRequest { get; set; }

        /// <summary>29 bits of identifier.</summary>
        bool ExtendedFrameFormat { get; set; }

        bool SingleShotMode { get; set; }

        bool HighPriorityMsg { get; set; }

        /// <summary>A CAN FD message.</summary>
        bool ExtendedDataLength { get; set; }

        bool FastDataRate { get; set; }

        bool ErrorStateIndicator { get; set; }

        byte this[int index] { get; set; }

        /// <summary>All zeros.</summary>
        void Clear();
    }

    /// <summary>A CAN message of up to 64 bytes; more than 8 need ExtendedDataLength.</summary>
    public interface ICanMessage2 : ICanMessage
    {
    }
}
