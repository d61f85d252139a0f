// What benchmarks/native.py measures in C#: a FIFO of the hub's, read by Ixxat.Vci4's own reader.
//
// read                  makes a FIFO, prints its number, and reads what a writer puts there, in blocks or one by one
// send NUMBER COUNT     puts messages there one by one, as ICanMessageWriter has it
using System;
using System.Diagnostics;
using System.Reflection;
using System.Runtime.InteropServices;
using System.Threading;
using Ixxat.Vci4;
using Ixxat.Vci4.Bal.Can;

static class Measured
{
    const ushort Room = 4000, MessageBytes = 80;

    [DllImport("libvciapi.so")]
    static extern int VciInitialize();

    [DllImport("libvciapi.so")]
    static extern int VciCreateFifo(out long id, ushort room, ushort size, ref Guid iid, out IntPtr fifo);

    [DllImport("libvciapi.so")]
    static extern int VciAccessFifo(ref long id, ref Guid iid, out IntPtr end);

    static Guid fifo2 = new Guid("66E3AA3A-6BF6-47A0-AB18-EFC801091E61");
    static Guid readerIid = new Guid("19286603-A9CD-433A-A495-72E5C9D97A97");
    static Guid writerIid = new Guid("E1CC08CE-99C0-483B-8E5F-4C43358E1CE2");

    static void Check(int result)
    {
        if (result != 0)
            throw new Exception(result.ToString("X8"));
    }

    /// <summary>What an ICanChannel2 gives, over the end of any FIFO of CANMSG2.</summary>
    static object End(string kind, long id, Guid iid)
    {
        IntPtr end;
        Check(VciAccessFifo(ref id, ref iid, out end));
        Type type = typeof(VciServer).Assembly.GetType("Ixxat.Vci4.Bal.Can." + kind, true);
        return Activator.CreateInstance(type, BindingFlags.Instance | BindingFlags.NonPublic, null, new object[] { end, true }, null);
    }

    static int Got(ICanMessageReader reader, bool blocks, uint expected)
    {
        ICanMessage2[] messages;
        ICanMessage2 one;
        int count = blocks ? reader.ReadMessages(out messages) : reader.ReadMessage(out one) ? Single(out messages, one) : None(out messages);
        for (int at = 0; at < count; at++)
            if (messages[at].Identifier != expected + at)
                throw new Exception("message " + messages[at].Identifier + " came in the place of " + (expected + at));
        return count;
    }

    static ICanMessage2[] last = new ICanMessage2[1];

    static int Single(out ICanMessage2[] messages, ICanMessage2 one)
    {
        messages = last;
        last[0] = one;
        return 1;
    }

    static int None(out ICanMessage2[] messages)
    {
        messages = null;
        return 0;
    }

    static void Read(bool blocks, uint count, string what)
    {
        long id;
        IntPtr fifo;
        Check(VciCreateFifo(out id, Room, MessageBytes, ref fifo2, out fifo));
        var reader = (ICanMessageReader)End("CanMessageReader", id, readerIid);
        var ready = new AutoResetEvent(false);
        reader.AssignEvent(ready);
        Console.WriteLine(id);
        Stopwatch watch = null;
        for (uint got = 0; got < count;)
        {
            int some = Got(reader, blocks, got);
            if (some == 0)
                ready.WaitOne(10);
            else
                watch = watch ?? Stopwatch.StartNew();
            got += (uint)some;
        }
        Console.WriteLine("C#     {0,-8} {1,6:F2} M frames/s", what, count / watch.Elapsed.TotalSeconds / 1e6);
    }

    static void Send(long id, uint count)
    {
        var writer = (ICanMessageWriter)End("CanMessageWriter", id, writerIid);
        var room = new AutoResetEvent(false);
        writer.AssignEvent(room);
        var message = (ICanMessage2)VciServer.Instance().MsgFactory.CreateMsg(typeof(ICanMessage2));
        message.DataLength = 8;
        for (uint k = 0; k < count;)
            if (writer.SendMessage(message))
                message.Identifier = ++k;
            else
                room.WaitOne(10);
        while (writer.FreeCount < Room) // the reader has all of it before this end goes
            Thread.Sleep(1);
    }

    static void Main(string[] words)
    {
        Check(VciInitialize());
        if (words[0] == "send")
            Send(long.Parse(words[1]), uint.Parse(words[2]));
        else
            Read(words[0] == "blocks", uint.Parse(words[1]), words[2]);
    }
}
