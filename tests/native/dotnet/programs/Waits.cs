// A program that waits for messages; it ends when it hears that the hub has gone.
using System;
using System.Threading;
using Ixxat.Vci4;
using Ixxat.Vci4.Bal;
using Ixxat.Vci4.Bal.Can;

static class Waits
{
    static void Main()
    {
        var channel = Boards.Socket<ICanChannel>(Boards.Open(0), 0);
        channel.Initialize(10, 10, false);
        ICanMessageReader reader = channel.GetMessageReader();
        var received = new AutoResetEvent(false);
        reader.AssignEvent(received);
        channel.Activate();
        Console.WriteLine("waiting");
        Boards.That(received.WaitOne(Boards.Long), "the event is set at the hub's end");
        ICanMessage message;
        Boards.Refused(VciError.VCI_E_DISCONNECTED, () => reader.ReadMessage(out message), "reading after that");
        reader.Dispose();
        Console.WriteLine("heard of it");
    }
}
