// An event of libcanwire's, and a thread that sets a .NET event whenever the first one is signalled.
using System;
using System.Collections.Generic;
using System.Threading;

namespace Canwire.Native
{
    /// <summary>
    /// .NET's events are not libcanwire's: what is assigned to a FIFO is a native event, and this thread, which costs
    /// nothing while nothing happens, hands each signal on. It ends with Dispose, or with the program.
    /// </summary>
    internal sealed class EventPump : IDisposable
    {
        private const uint Forever = 0xFFFFFFFF;
        private const int ManyInARow = 100;

        private static readonly List<EventPump> running = new List<EventPump>();
        private static Thread guard;

        private readonly EventWaitHandle target;
        private readonly Thread thread;
        private volatile bool ended;

        internal EventPump(EventWaitHandle target)
        {
            this.target = target;
            Handle = Library.CreateEventA(IntPtr.Zero, 0, 0, IntPtr.Zero);
            if (Handle == IntPtr.Zero)
                throw new OutOfMemoryException("VCI has no room for another event");
            lock (running)
            {
                running.Add(this);
                guard = guard ?? Started(Guard, "canwire exit");
            }
            thread = Started(Run, "canwire events");
        }

        /// <summary>The native event.</summary>
        internal IntPtr Handle { get; private set; }

        /// <summary>End the thread; nothing may signal the native event from now on.</summary>
        public void Dispose()
        {
            lock (running)
                if (!running.Remove(this))
                    return;
            End();
            thread.Join();
            Library.CloseHandle(Handle);
        }

        private static Thread Started(ThreadStart run, string name)
        {
            var made = new Thread(run) { IsBackground = true, Name = name };
            made.Start();
            return made;
        }

        /// <summary>
        /// Mono aborts background threads when a program ends, and waits for them; one that is in a native wait does not
        /// hear of it. This one does, and ends the others.
        /// </summary>
        private static void Guard()
        {
            try
            {
                Thread.Sleep(Timeout.Infinite);
            }
            finally
            {
                lock (running)
                    foreach (EventPump one in running)
                        one.End();
            }
        }

        private void End()
        {
            ended = true;
            Library.SetEvent(Handle);
        }

        private void Run()
        {
            int inARow = 0;
            while (Next(ref inARow) && !ended)
                try
                {
                    HandOn(inARow);
                }
                catch (ObjectDisposedException) // the program has thrown its event away: nobody waits for it
                {
                    return;
                }
        }

        private bool Next(ref int inARow)
        {
            if (Library.WaitForSingleObject(Handle, 0) == 0)
            {
                inARow++;
                return true;
            }
            inARow = 0;
            return Library.WaitForSingleObject(Handle, Forever) == 0;
        }

        /// <summary>
        /// What has ended (a hub, a queue that was made anew) signals until the program looks: where signals come without a
        /// wait between them, and the program has not taken the last one, it gets a millisecond.
        /// </summary>
        private void HandOn(int inARow)
        {
            bool wasSet = target.WaitOne(0);
            target.Set();
            if (wasSet && inARow > ManyInARow)
                Thread.Sleep(1);
        }
    }
}
