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
        private readonly object gate = new object();
        private EventPump pump;
        private bool over;

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
            lock (gate)
            {
                if (over)
                    throw new ObjectDisposedException("the FIFO or list");
                var made = new EventPump(target);
                int result = of.Call(slot, (void*)made.Handle);
                EventPump gone = result == Results.Ok ? pump : made;
                if (result == Results.Ok)
                    pump = made;
                if (gone != null)
                    gone.Dispose();
                return result;
            }
        }

        public void Dispose()
        {
            lock (gate)
            {
                over = true;
                if (pump == null)
                    return;
                of.Call(slot, (void*)null);
                pump.Dispose();
                pump = null;
            }
        }
    }
}
