// Objects that many threads use while another one disposes of them: nothing but the documented exceptions.
using System;
using System.Threading;
using Ixxat.Vci4;
using Ixxat.Vci4.Bal;
using Ixxat.Vci4.Bal.Can;

static class Threads
{
    const int Rounds = 3, Users = 3;

    static int failures;

    // Until it is disposed of; what else it throws is a failure.
    static void Use(Action action, CountdownEvent used)
    {
        bool first = true;
        try
        {
            for (;;)
            {
                try
                {
                    action();
                }
                catch (VciException) // a code of the interface: busy, in use, no such handle
                {
                }
                catch (InvalidOperationException error) // a message of a list that another thread has reset meanwhile
                {
                    if (error is ObjectDisposedException)
                        throw;
                }
                catch (ArgumentOutOfRangeException) // the list is full meanwhile
                {
                }
                if (first)
                    used.Signal();
                first = false;
            }
        }
        catch (ObjectDisposedException)
        {
            if (first)
                used.Signal();
        }
        catch (Exception error)
        {
            Interlocked.Increment(ref failures);
            Console.WriteLine(error);
            if (first)
                used.Signal();
        }
    }

    // Each action in threads of its own, and Dispose, by two at once, once all have been there.
    static void Played(IDisposable thing, params Action[] actions)
    {
        var used = new CountdownEvent(actions.Length * Users);
        var threads = new Thread[actions.Length * Users + 2];
        for (int at = 0; at < threads.Length - 2; at++)
        {
            Action action = actions[at % actions.Length];
            threads[at] = new Thread(() => Use(action, used));
            threads[at].Start();
        }
        Boards.That(used.Wait(Boards.Long), "every thread has used it");
        for (int at = threads.Length - 2; at < threads.Length; at++)
        {
            threads[at] = new Thread(thing.Dispose);
            threads[at].Start();
        }
        foreach (Thread thread in threads)
            Boards.That(thread.Join(Boards.Long), "every thread ends");
    }

    static void Round(IBalObject board)
    {
        var channel = Boards.Socket<ICanChannel>(board, 0);
        channel.Initialize(100, 100, false);
        channel.Activate();
        ICanMessageReader reader = channel.GetMessageReader();
        ICanMessageWriter writer = channel.GetMessageWriter();
        var message = (ICanMessage)VciServer.Instance().MsgFactory.CreateMsg(typeof(ICanMessage));
        ICanMessage one;
        ICanMessage[] many;
        message.SelfReceptionRequest = true;
        Played(reader, () => reader.ReadMessages(out many), () => reader.ReadMessage(out one),
            () => reader.AssignEvent(new AutoResetEvent(false)));
        Played(writer, () => writer.SendMessage(message), () => writer.AssignEvent(new ManualResetEvent(false)));
        Played(channel, () => channel.Activate(), () => { var status = channel.ChannelStatus; },
            () => channel.GetMessageReader().Dispose());
        var list = Boards.Socket<ICanScheduler>(board, 0);
        Played(list, () => list.Resume(), () => { list.Reset(); list.AddMessage().Start(1); });
    }

    static void Main()
    {
        IBalObject board = Boards.Open(0);
        var control = Boards.Socket<ICanControl>(board, 0);
        control.InitLine(CanOperatingModes.Standard, CanBitrate.Cia1000KBit);
        control.StartLine();
        for (int round = 0; round < Rounds; round++)
            Round(board);
        Played(control, () => control.StartLine(), () => control.AddFilterIds(CanFilter.Std, 1, 1));
        Played(board, () => { var socket = board.OpenSocket(0, typeof(ICanSocket)); socket.Dispose(); });
        Boards.Is(failures, 0, "what was thrown besides");
        Console.WriteLine("whatever the threads did");
    }
}
