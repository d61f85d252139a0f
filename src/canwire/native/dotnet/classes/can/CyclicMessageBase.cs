// What messages of cyclic lists have. Source: VCI V3 .NET manual 4.2.5; the contract of Ixxat.Vci4.
using System;
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3.Bal.Can
#else
namespace Ixxat.Vci4.Bal.Can
#endif
{
    /// <summary>A message that a line sends again and again; its TimeStamp means nothing.</summary>
#if VCI3
    public abstract unsafe class CyclicMessageBase : CanMessageBase
#else
    internal abstract unsafe class CyclicMessageBase : CanMessageBase
#endif
    {
        private byte index;

        internal CyclicMessageBase()
        {
        }

        /// <summary>1 to MaxCyclicMessageTicks.</summary>
        public ushort CycleTicks { get; set; }

        public CanCyclicTXIncMode AutoIncrementMode { get; set; }

        /// <summary>The byte that counts up, from 0; of two bytes the low one.</summary>
        public byte AutoIncrementIndex
        {
            get { return index; }
            set
            {
                if (value >= Room)
                    throw new ArgumentOutOfRangeException("index", value, "a message here has bytes 0 to " + (Room - 1));
                index = value;
            }
        }

        public override void Clear()
        {
            base.Clear();
            CycleTicks = 0;
            AutoIncrementMode = CanCyclicTXIncMode.NoInc;
            index = 0;
        }

        internal CanCyclicMsg Structure()
        {
            var made = new CanCyclicMsg {
                CycleTicks = CycleTicks, Mode = (byte)AutoIncrementMode, Index = index, Identifier = Raw.Identifier,
                Info = Raw.Info
            };
            for (int at = 0; at < Room; at++)
                made.Data[at] = this[at];
            return made;
        }
    }
}
