// The bits of CANMSGINFO, as one word. Source: cantype.h.
namespace Canwire.Native
{
    internal static class Info
    {
        internal const uint SingleShot = 1 << 8, HighPriority = 1 << 9, LongData = 1 << 10, FastData = 1 << 11;
        internal const uint ErrorState = 1 << 12, Overrun = 1 << 20, SelfReception = 1 << 21, Remote = 1 << 22;
        internal const uint Extended = 1 << 23;

        private const int LengthAt = 16, AcceptAt = 24;
        private static readonly byte[] lengths = { 0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64 };

        internal static uint With(uint info, uint bit, bool set)
        {
            return set ? info | bit : info & ~bit;
        }

        internal static uint Type(uint info)
        {
            return info & 0xFF;
        }

        internal static uint WithType(uint info, uint type)
        {
            return info & ~0xFFu | type & 0xFF;
        }

        internal static uint Accepted(uint info)
        {
            return info >> AcceptAt;
        }

        /// <summary>The data length code, 0 to 15.</summary>
        internal static uint Code(uint info)
        {
            return info >> LengthAt & 0xF;
        }

        internal static uint WithCode(uint info, uint code)
        {
            return info & ~(0xFu << LengthAt) | code << LengthAt;
        }

        /// <summary>The bytes that a code of CAN FD means.</summary>
        internal static byte Length(uint code)
        {
            return lengths[code];
        }

        /// <summary>The code of the shortest length that holds so many bytes.</summary>
        internal static uint CodeOf(byte length)
        {
            uint code = 0;
            while (lengths[code] < length)
                code++;
            return code;
        }
    }
}
