// VCI's result codes as far as the classes look at them. Source: vcierr.h.
namespace Canwire.Native
{
    internal static class Results
    {
        internal const int Ok = 0;
        internal const int InvalidArgument = unchecked((int)0xE0010004);
        internal const int NoInterface = unchecked((int)0xE0010005);
        internal const int NotImplemented = unchecked((int)0xE0010002);
        internal const int Timeout = unchecked((int)0xE001000B);
        internal const int NoMoreItems = unchecked((int)0xE001000F);
        internal const int ReceiveQueueEmpty = unchecked((int)0xE0010012);
        internal const int TransmitQueueFull = unchecked((int)0xE0010013);
        internal const int Disconnected = unchecked((int)0xE0010019);
    }
}
