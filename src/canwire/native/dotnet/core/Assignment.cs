// The one event that a FIFO or a device list signals.
using System;
using System.Threading;

namespace Canwire.Native
{
    /// <summary>AssignEvent of one native object: each event takes the place of the one before.</summary>
    internal sealed unsafe class Assignment : IDisposable
    {
        private readonly NativeObject of;
        private readonly int slot;
        private EventPump pump;

        internal Assignment(NativeObject of, int slot)
        {
            this.of = of;
            this.slot = slot;
        }

        /// <summary>The result code; ArgumentNullException for no event.</summary>
        internal int Assign(EventWaitHandle target)
        {
            if (target == null)
                throw new ArgumentNullException("fifoEvent");
            var made = new EventPump(target);
            int result = of.Call(slot, (void*)made.Handle);
            if (result != Results.Ok)
            {
                made.Dispose();
                return result;
            }
            if (pump != null)
                pump.Dispose();
            pump = made;
            return result;
        }

        public void Dispose()
        {
            if (pump == null)
                return;
            of.Call(slot, (void*)null);
            pump.Dispose();
            pump = null;
        }
    }
}
